#!/usr/bin/python3
"""weft farm: on the local engine, and on a real Slurm of one node that is started and ended here (skipped where
its packages are absent). Whatever happens on the way, the result is the single run's, byte for byte.

    WEFT=build/weft SOURCE=. /usr/bin/python3 tests/cli/farm_test.py
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import slurm_cluster

WEFT = os.path.abspath(os.environ["WEFT"])
GRAPHS = pathlib.Path(os.environ["SOURCE"]).resolve() / "graphs"
SHARDS = 4


def processes_of(folder, shard):
    """Pids of the weft that does a shard of the job in a folder."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
            except OSError:
                continue
            if len(words) > 2 and words[1] == "run" and f"{shard}/{SHARDS}" in words and words[2].startswith(str(folder)):
                found.append(int(entry.name))
    return found


class FarmCase(unittest.TestCase):
    """What both engines must do. Subclasses say which, and with which environment."""
    engine = None
    environment = None

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name).resolve()
        (self.path / "make.json").write_text("""{"weft": 1, "nodes": {
            "make": {"type": "analytic-samples", "set": {"width": 72, "height": 56, "spp": 2}},
            "write": {"type": "write-samples", "in": {"samples": "make"}, "set": {"file": "small.npz"}}}}""")
        self.job = self.path / "job"
        self.weft("run", "make.json", "--quiet")

    def weft(self, *arguments, status=0):
        done = subprocess.run([WEFT, *map(str, arguments)], cwd=self.path, capture_output=True, text=True, timeout=240, env=self.environment)
        self.assertEqual(done.returncode, status, done.stdout + done.stderr + self.logs())
        return done.stdout + done.stderr

    def arguments(self, *more, locations=16):
        return ["farm", GRAPHS / "tlfr.json", "--shards", SHARDS, "--engine", self.engine, "--set", "samples=small.npz", "--set",
                f"locations={locations}", "--set", "out=farm/a.exr", "--folder", "job", "--tile", "8", *more]

    def logs(self):
        return "".join(f"\n--- {p.name}\n{p.read_text(errors='replace')[-1500:]}" for p in sorted(self.job.glob("logs/*")))

    def expect_the_single_runs_bytes(self, locations=16):
        self.weft("run", GRAPHS / "tlfr.json", "--quiet", "--set", "samples=small.npz", "--set", f"locations={locations}", "--set",
                  "out=single/a.exr")
        for name in ("a.exr", "a.png"):
            self.assertEqual((self.path / "single" / name).read_bytes(), (self.path / "farm" / name).read_bytes(), name)

    def start(self, *more, locations):
        return subprocess.Popen([WEFT, *map(str, self.arguments(*more, locations=locations))], cwd=self.path, stderr=subprocess.PIPE,
                                stdout=subprocess.PIPE, text=True, env=self.environment)

    def wait_for_shard(self, shard, farm):
        end = time.monotonic() + 60
        while not (found := processes_of(self.job, shard)):
            self.assertIsNone(farm.poll(), "the farm ended before its shard ran")
            self.assertLess(time.monotonic(), end, self.logs())
            time.sleep(0.02)
        return found

    def parts(self):
        return {p.name: p.stat().st_mtime_ns for p in self.job.glob("parts/*")}


class Both:
    def test_gives_the_single_runs_bytes(self):
        said = self.weft(*self.arguments())
        self.expect_the_single_runs_bytes()
        for shard in range(1, SHARDS + 1):
            self.assertIn(f"shard {shard}/{SHARDS}: done", said)
        self.assertEqual(len(self.parts()), SHARDS)

    def test_a_shard_killed_in_the_middle_runs_again(self):
        farm = self.start(locations=3000)
        time.sleep(0.3)
        for pid in self.wait_for_shard(2, farm):
            os.kill(pid, signal.SIGKILL)
        said = farm.communicate(timeout=240)
        self.assertEqual(farm.returncode, 0, said[1] + self.logs())
        self.expect_the_single_runs_bytes(locations=3000)

    def test_a_shard_that_fails_is_named_with_its_log_and_resumed(self):
        (self.job / "parts/3.part/in-the-way").mkdir(parents=True)  # it cannot write its part
        said = self.weft(*self.arguments(), status=1)
        self.assertIn(f"shard 3/{SHARDS} failed", said)
        self.assertIn("is a folder; name a file in it", said)  # from its log
        self.assertIn("--resume", said)
        self.assertFalse((self.path / "farm").exists())
        shutil.rmtree(self.job / "parts/3.part")

        before = self.parts()
        self.assertEqual(sorted(before), ["1.part", "2.part", "4.part"])
        self.assertIn("holds a job already", self.weft(*self.arguments(), status=2))
        said = self.weft(*self.arguments("--resume"))
        self.assertIn(f"1 of {SHARDS} shards", said)
        self.assertEqual({name: made for name, made in self.parts().items() if name in before}, before, "a part that was done was made again")
        self.expect_the_single_runs_bytes()

        said = self.weft(*self.arguments("--resume", locations=17))  # another key: all of them
        self.assertIn(f"{SHARDS} of {SHARDS} shards", said)
        self.expect_the_single_runs_bytes(locations=17)


class Local(Both, FarmCase):
    engine = "local"

    def test_a_graph_that_is_wrong_starts_nothing(self):
        self.assertIn("did you mean", self.weft(*self.arguments("--set", "lcoations=3"), status=2))
        self.assertIn("nowhere.npz", self.weft(*self.arguments("--set", "samples=nowhere.npz"), status=1))
        self.assertIn("without --shard", self.weft("farm", GRAPHS / "box.json", "--shards", 2, "--engine", "local", status=2))
        self.assertIn("--shards", self.weft("farm", GRAPHS / "box.json", status=2))
        self.assertFalse(self.job.exists())

    def test_a_dry_run_writes_nothing(self):
        said = self.weft(*self.arguments("--dry-run"))
        self.assertIn("#!/bin/sh", said)
        self.assertEqual(len(re.findall(r"(?m)^/bin/sh .*/run\.sh (?:\d|merge)", said)), SHARDS + 1)
        self.assertEqual(sorted(p.name for p in self.path.iterdir()), ["make.json", "small.npz"])

    def test_names_with_blanks_and_quotes(self):
        self.weft(*self.arguments("--set", "out=farm/it's a picture.exr", "--at-once", 2))
        self.assertTrue((self.path / "farm/it's a picture.exr").exists())

    def test_a_worker_that_sees_another_file_refuses(self):
        self.weft(*self.arguments())
        (self.path / "make.json").write_text((self.path / "make.json").read_text().replace('"spp": 2', '"spp": 3'))
        self.weft("run", "make.json", "--quiet")
        done = subprocess.run(["/bin/sh", self.job / "run.sh", "1"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("small.npz: is another file than the job was planned with", done.stderr)
        (self.path / "small.npz").unlink()
        done = subprocess.run(["/bin/sh", self.job / "run.sh", "1"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("small.npz", done.stderr)

    def test_a_worker_with_another_instruction_set_or_program_refuses(self):
        self.weft(*self.arguments())
        job = json.loads((self.job / "job.json").read_text())
        script = (self.job / "run.sh").read_text()
        (self.job / "run.sh").write_text(re.sub("--isa v[34]", "--isa v2", script))
        if job["isa"] != "v2":
            done = subprocess.run(["/bin/sh", self.job / "run.sh", "1"], capture_output=True, text=True)
            self.assertIn("planned for instruction set", done.stderr)
            self.assertEqual(done.returncode, 1)
        (self.job / "run.sh").write_text(script)
        (self.job / "job.json").write_text(json.dumps({**job, "weft": "0.0.0"}))
        done = subprocess.run(["/bin/sh", self.job / "run.sh", "1"], capture_output=True, text=True)
        self.assertIn("planned with weft 0.0.0", done.stderr)
        self.assertEqual(done.returncode, 1)

    def test_a_merge_that_fails_is_named_and_resumed(self):
        (self.path / "farm").write_text("in the way of the folder")
        said = self.weft(*self.arguments(), status=1)
        self.assertIn("the merge failed", said)
        self.assertIn("farm", said)
        (self.path / "farm").unlink()
        self.assertIn(f"0 of {SHARDS} shards", self.weft(*self.arguments("--resume")))
        self.expect_the_single_runs_bytes()

    def test_ctrl_c_ends_the_shards_and_resume_goes_on(self):
        farm = self.start(locations=3000)
        self.wait_for_shard(2, farm)
        farm.send_signal(signal.SIGINT)
        said = farm.communicate(timeout=60)
        self.assertEqual(farm.returncode, 130, said[1])
        self.assertIn("--resume", said[1])
        self.assertEqual(processes_of(self.job, 2), [])
        self.assertEqual([p.name for p in self.job.glob("parts/*") if p.name != "1.part"], [])
        self.weft(*self.arguments("--resume", locations=3000))
        self.expect_the_single_runs_bytes(locations=3000)


@unittest.skipIf(slurm_cluster.why_not(), f"no Slurm here: {slurm_cluster.why_not()}")
class OnSlurm(Both, FarmCase):
    engine = "slurm"

    @classmethod
    def setUpClass(cls):
        cls.cluster_folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.cluster_folder.cleanup)
        cls.slurm = slurm_cluster.Slurm(cls.cluster_folder.name).start()
        cls.addClassCleanup(cls.slurm.stop)
        cls.environment = cls.slurm.environment

    def test_a_shard_that_slurm_queues_again_starts_again(self):
        farm = self.start(locations=3000)
        self.wait_for_shard(1, farm)
        job = json.loads((self.job / "engine.json").read_text())["array"]
        asked = self.slurm.run("scontrol", "requeue", f"{job}_1")
        self.assertEqual(asked.returncode, 0, asked.stderr)
        said = farm.communicate(timeout=240)
        self.assertEqual(farm.returncode, 0, said[1] + self.logs())
        self.expect_the_single_runs_bytes(locations=3000)

    def test_ctrl_c_leaves_the_jobs_running_and_they_are_followed_again(self):
        farm = self.start(locations=3000)
        self.wait_for_shard(1, farm)
        farm.send_signal(signal.SIGINT)
        said = farm.communicate(timeout=30)[1]
        self.assertEqual(farm.returncode, 130, said)
        self.assertIn("--follow", said)
        self.assertIn("is still in the queue", self.weft(*self.arguments("--resume", locations=3000), status=1))
        self.assertIn("done: farm/a.exr", self.weft("farm", "--folder", "job", "--follow"))
        self.expect_the_single_runs_bytes(locations=3000)
        self.assertIn("done: farm/a.exr", self.weft("farm", "--folder", "job", "--follow"))

    def test_what_slurm_refuses_is_said(self):
        said = self.weft(*self.arguments("--partition", "nowhere"), status=1)
        self.assertIn("sbatch refused the job", said)
        self.assertIn("nowhere", said)


class WithoutSlurm(FarmCase):
    engine = "slurm"

    def test_a_machine_without_slurm_says_so(self):
        self.environment = {**os.environ, "PATH": "/nowhere"}
        self.assertIn("--engine local", self.weft(*self.arguments(), status=1))


if __name__ == "__main__":
    unittest.main()
