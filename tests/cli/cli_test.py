#!/usr/bin/python3
"""The program as its users meet it: exit statuses, what goes where, interruption, repetition.

    WEFT=build/weft SOURCE=. /usr/bin/python3 tests/cli/cli_test.py
"""
import json
import os
import pathlib
import pty
import resource
import select
import signal
import subprocess
import tempfile
import time
import unittest

WEFT = os.path.abspath(os.environ["WEFT"])
GRAPHS = pathlib.Path(os.environ["SOURCE"]).resolve() / "graphs"


def weft(*arguments, cwd, **options):
    return subprocess.run([WEFT, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=120, **options)


class Cli(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = pathlib.Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def document(self, text, name="graph.json"):
        (self.path / name).write_text(text)
        return name

    def run_ok(self, *arguments):
        done = weft(*arguments, cwd=self.path)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def small_samples(self):
        self.document("""{"weft": 1, "nodes": {
            "make": {"type": "analytic-samples", "set": {"width": 40, "height": 24, "spp": 2}},
            "write": {"type": "write-samples", "in": {"samples": "make"}, "set": {"file": "small.npz"}}}}""", "make.json")
        self.run_ok("run", "make.json", "--quiet")
        return "small.npz"

    def files(self):
        return sorted(str(p.relative_to(self.path)) for p in self.path.rglob("*") if p.is_file())

    # --- exit statuses -------------------------------------------------------------------------

    def test_a_wrong_document_is_status_2_with_every_finding_at_its_place(self):
        self.document('{"weft": 1,\n "nodes": {\n  "a": {"type": "read-sampels"},\n  "b": {"type": "pixel-filter", "set": {"fliter": "box"}}}}')
        done = weft("check", "graph.json", cwd=self.path)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stdout, "")
        self.assertIn("graph.json:3:17: error: no node type 'read-sampels'; did you mean 'read-samples'?", done.stderr)
        self.assertIn("graph.json:4:", done.stderr)
        self.assertIn("did you mean 'filter'?", done.stderr)
        self.assertEqual(weft("run", "graph.json", cwd=self.path).returncode, 2)

    def test_a_wrong_command_line_is_status_2(self):
        for arguments in (["rnu"], ["run"], ["run", GRAPHS / "box.json", "--threads", "none"], ["node", "pixel-fliter"], ["nodes", "colour"],
                          ["run", GRAPHS / "box.json", "--memory", "plenty"], ["run", GRAPHS / "box.json", "--set", "smaples=x"],
                          ["run", GRAPHS / "box.json", "--isa", "v9"], ["run", GRAPHS / "box.json", "--tap", "nothing.here=x.json"]):
            done = weft(*arguments, cwd=self.path)
            self.assertEqual(done.returncode, 2, arguments)
            self.assertNotEqual(done.stderr, "")
        self.assertEqual(self.files(), [])

    def test_a_missing_input_is_status_1_and_named(self):
        done = weft("run", GRAPHS / "box.json", "--set", "samples=nowhere.npz", "--set", "out=a.exr", cwd=self.path)
        self.assertEqual(done.returncode, 1)
        self.assertIn("nowhere.npz", done.stderr)
        self.assertIn("'samples'", done.stderr)
        self.assertEqual(self.files(), [])

    def test_half_a_sample_file_is_status_1_and_leaves_no_picture(self):
        whole = (self.path / self.small_samples()).read_bytes()
        (self.path / "half.npz").write_bytes(whole[: len(whole) // 2])
        done = weft("run", GRAPHS / "box.json", "--quiet", "--set", "samples=half.npz", "--set", "out=a.exr", cwd=self.path)
        self.assertEqual(done.returncode, 1)
        self.assertIn("half.npz", done.stderr)
        self.assertFalse((self.path / "a.exr").exists())

    def test_what_is_skipped_is_said_by_a_few_names(self):
        (self.path / "bad.npz").write_bytes(b"no samples")
        done = weft("run", GRAPHS / "tlfr.json", "--set", "samples=bad.npz", cwd=self.path)
        self.assertEqual(done.returncode, 1)
        line = next(l for l in done.stderr.splitlines() if "skipped because of it: " in l)
        names, more = line.split("skipped because of it: ")[1].split(" and ")
        self.assertEqual(len(names.split(", ")), 6)
        self.assertRegex(more, r"^\d+ more$")

    def test_a_plan_that_does_not_fit_is_status_1_and_says_what_it_needs(self):
        done = weft("run", GRAPHS / "tlfr.json", "--memory", "1M", "--set", "out=a.exr", cwd=self.path)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"needs .* while '.*' runs")
        self.assertIn("--memory allows 1 MB", done.stderr)
        self.assertEqual(self.files(), [])

    def test_a_full_disk_leaves_what_was_there(self):
        samples = self.small_samples()
        (self.path / "a.exr").write_text("precious")
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
        done = weft("run", GRAPHS / "box.json", "--quiet", "--set", f"samples={samples}", "--set", "out=a.exr", cwd=self.path,
                    preexec_fn=lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_IGN), limit()))
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("a.exr", done.stderr)
        self.assertEqual((self.path / "a.exr").read_text(), "precious")
        self.assertEqual([f for f in self.files() if f.endswith(".part")], [])

    # --- interruption --------------------------------------------------------------------------

    def test_ctrl_c_ends_within_a_second_and_leaves_no_partial_file(self):
        process = subprocess.Popen([WEFT, "run", str(GRAPHS / "tlfr.json"), "--set", "locations=4096", "--set", "out=a.exr"],
                                   cwd=self.path, stderr=subprocess.PIPE, text=True)
        time.sleep(1.5)
        self.assertIsNone(process.poll(), "ended by itself")
        process.send_signal(signal.SIGINT)
        asked = time.monotonic()
        _, said = process.communicate(timeout=30)
        took = time.monotonic() - asked
        self.assertEqual(process.returncode, 130)
        self.assertIn("interrupted", said)
        self.assertLess(took, 3.0)  # a second on a machine of our own; others may be busy
        self.assertEqual(self.files(), [])

    # --- what is shown ---------------------------------------------------------------------------

    def test_a_terminal_gets_bars_and_quiet_gets_nothing(self):
        samples = self.small_samples()
        done = self.run_ok("run", GRAPHS / "tlfr.json", "--quiet", "--set", f"samples={samples}", "--set", "out=a.exr", "--set", "locations=4")
        self.assertEqual(done.stdout + done.stderr, "")

        primary, secondary = pty.openpty()
        process = subprocess.Popen([WEFT, "run", str(GRAPHS / "tlfr.json"), "--set", "locations=2048", "--set", "out=b.exr"],
                                   cwd=self.path, stderr=secondary, stdout=subprocess.DEVNULL)
        os.close(secondary)
        shown, end = b"", time.monotonic() + 20
        while b"tiles" not in shown and time.monotonic() < end:
            if select.select([primary], [], [], 0.5)[0]:
                shown += os.read(primary, 65536)
        process.send_signal(signal.SIGTERM)
        while True:
            try:
                more = os.read(primary, 65536)
            except OSError:
                break
            if not more:
                break
            shown += more
        self.assertEqual(process.wait(timeout=20), 130)
        self.assertRegex(shown, rb"\[[#.]{24}\] +\d+ %")

    def test_results_are_on_stdout_and_colour_only_on_a_terminal(self):
        for command in (["nodes"], ["node", "pixel-filter"], ["schema"], ["plan", GRAPHS / "box.json"], ["dot", GRAPHS / "box.json"],
                        ["dot", "--mermaid", GRAPHS / "box.json"], ["check", GRAPHS / "box.json"], ["--version"]):
            done = self.run_ok(*command)
            self.assertNotEqual(done.stdout, "", command)
            self.assertEqual(done.stderr, "", command)
            self.assertNotIn("\x1b", done.stdout)

    def test_json_where_a_program_may_want_it(self):
        samples = self.small_samples()
        for command in (["nodes", "--json"], ["node", "reproject", "--json"], ["plan", GRAPHS / "tlfr.json", "--json"],
                        ["check", "--json", GRAPHS / "tlfr.json"], ["show", "--json", samples], ["schema"]):
            json.loads(self.run_ok(*command).stdout)

    # --- a whole run -----------------------------------------------------------------------------

    def test_the_report_counts_locations_and_the_trace_is_json(self):
        samples = self.small_samples()
        self.run_ok("run", GRAPHS / "tlfr.json", "--quiet", "--threads", "2", "--set", f"samples={samples}", "--set", "locations=4", "--set",
                    "out=a.exr", "--report", "r.json", "--trace", "t.json")
        report = json.loads((self.path / "r.json").read_text())
        stages = [stage for segment in report["segments"] for stage in segment["stages"]]
        self.assertEqual(max(stage["items"].get("locations", 0) for stage in stages), 40 * 24 * 4)
        self.assertEqual(report["threads"], 2)
        self.assertGreater(report["peak_bytes"], 0)
        self.assertTrue(json.loads((self.path / "t.json").read_text())["traceEvents"])

    def test_a_picture_repeats_its_run_to_the_same_bytes(self):
        samples = self.small_samples()
        self.run_ok("run", GRAPHS / "tlfr.json", "--quiet", "--set", f"samples={samples}", "--set", "locations=4", "--set", "out=a/one.exr")
        self.run_ok("run", GRAPHS / "tlfr.json", "--quiet", "--set", f"samples={samples}", "--set", "locations=4", "--set", "out=b/two.exr")
        one = (self.path / "a/one.exr").read_bytes()
        self.assertEqual(one, (self.path / "b/two.exr").read_bytes())
        for picture in ("a/one.exr", "a/one.png"):
            self.run_ok("run", picture, "--quiet", "--set", "out=c/three.exr")
            self.assertEqual(one, (self.path / "c/three.exr").read_bytes(), picture)
        self.assertIn("locations", self.run_ok("show", "a/one.exr").stdout)

    # --- shards ----------------------------------------------------------------------------------

    def shard(self, part, shard, *more, graph=GRAPHS / "tlfr.json"):
        return weft("run", graph, "--quiet", "--set", "samples=small.npz", "--set", "locations=4", "--shard", shard, "--part", part, *more,
                    cwd=self.path)

    def test_shards_merge_to_the_single_runs_bytes(self):
        samples = self.small_samples()
        self.run_ok("run", GRAPHS / "tlfr.json", "--quiet", "--set", f"samples={samples}", "--set", "locations=4", "--set", "out=one/a.exr")
        for n, tile in ((1, 32), (2, 7), (5, 16)):
            parts = [f"parts/{n}-{i}" for i in range(1, n + 1)]
            for i, part in enumerate(parts):
                done = self.shard(part, f"{i + 1}/{n}", "--tile", tile, "--threads", i % 2 + 1, "--set", "out=never/a.exr")
                self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))
            self.run_ok("merge", f"two/{n}.exr", *reversed(parts), "--quiet")
            for kind in ("exr", "png"):
                self.assertEqual((self.path / f"one/a.{kind}").read_bytes(), (self.path / f"two/{n}.{kind}").read_bytes(), (n, kind))
        self.assertFalse((self.path / "never").exists())
        self.run_ok("run", "two/5.exr", "--quiet", "--set", "out=three.exr")  # what it says of itself can be run
        self.assertEqual((self.path / "one/a.exr").read_bytes(), (self.path / "three.exr").read_bytes())

    def test_a_part_that_does_not_belong_is_named(self):
        self.small_samples()
        for i in (1, 2, 3):
            self.assertEqual(self.shard(f"{i}.part", f"{i}/3").returncode, 0)

        def refused(*parts):
            done = weft("merge", "a.exr", *parts, "--quiet", cwd=self.path)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertFalse((self.path / "a.exr").exists())
            return done.stderr

        self.assertIn("shard 2/3", refused("1.part", "3.part"))
        self.assertIn("1.part and 1.part are both shard 1/3", refused("1.part", "1.part", "2.part", "3.part"))
        self.assertIn("nowhere.part: cannot open", refused("1.part", "2.part", "nowhere.part"))
        self.assertIn("small.npz: is no part", refused("1.part", "2.part", "small.npz"))
        whole = (self.path / "3.part").read_bytes()
        (self.path / "cut.part").write_bytes(whole[: len(whole) // 2])
        self.assertIn("cut.part: is damaged", refused("1.part", "2.part", "cut.part"))
        spoilt = bytearray((self.path / "1.part").read_bytes())
        spoilt[100] ^= 1
        (self.path / "spoilt.part").write_bytes(spoilt)
        self.assertRegex(refused("spoilt.part", "2.part", "3.part"), r"spoilt.part: is damaged: tile or piece \d+ has another checksum")
        self.shard("isa.part", "3/3", "--isa", "v2")
        if "avx2" in pathlib.Path("/proc/cpuinfo").read_text():
            self.assertIn("isa.part: is not of the same run as 1.part: made with instruction set v2", refused("1.part", "2.part", "isa.part"))
        self.shard("other.part", "3/3", "--set", "locations=5")
        self.assertIn("made of another graph, or with other parameters", refused("1.part", "2.part", "other.part"))
        make = (self.path / "make.json").read_text()
        self.document(make.replace('"spp": 2', '"spp": 3'), "make.json")
        self.run_ok("run", "make.json", "--quiet")
        self.shard("input.part", "3/3")
        self.assertIn("made of other input files", refused("1.part", "2.part", "input.part"))

    def test_a_graph_that_cannot_be_divided_is_refused_with_what_to_do(self):
        self.small_samples()
        done = self.shard("a.part", "1/2", "--bypass", "smooth", graph=GRAPHS / "tlfr.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        done = weft("run", GRAPHS / "box.json", "--shard", "1/2", cwd=self.path)
        self.assertEqual(done.returncode, 2)
        self.assertIn("run it whole, without --shard", done.stderr)
        for wrong in (["--shard", "3/2"], ["--part", "a.part"], ["--shard", "1/2", "--divide", "nothing"], ["--shard", "1/2", "--tap", "picture=a.json"]):
            self.assertEqual(weft("run", GRAPHS / "tlfr.json", *wrong, cwd=self.path).returncode, 2, wrong)

    def test_a_node_that_makes_samples_is_divided(self):
        common = ["--quiet", "--swap", "samples=analytic-samples,width=50,height=40,spp=3"]
        self.run_ok("run", GRAPHS / "box.json", *common, "--set", "out=one.exr")
        for i in (1, 2):
            self.run_ok("run", GRAPHS / "box.json", *common, "--shard", f"{i}/2", "--part", f"{i}.part")
        self.run_ok("merge", "two.exr", "1.part", "2.part", "--quiet")
        self.assertEqual((self.path / "one.exr").read_bytes(), (self.path / "two.exr").read_bytes())

    def test_plans_show_keys_of_what_goes_in(self):
        samples = self.small_samples()

        def keys(*more):
            plan = json.loads(self.run_ok("plan", GRAPHS / "tlfr.json", "--json", "--set", f"samples={samples}", *more).stdout)
            return {made["value"]: made["key"] for task in plan["tasks"] for made in task["makes"]}, plan["key"]

        before, run = keys()
        self.assertEqual((before, run), keys("--set", "out=elsewhere.exr"))
        after, other = keys("--set", "locations=5")
        self.assertEqual(before["smooth.samples"], after["smooth.samples"])
        self.assertNotEqual(before["picture.image"], after["picture.image"])
        self.assertNotEqual(run, other)
        self.assertIn(before["picture.image"], self.run_ok("plan", GRAPHS / "tlfr.json", "--set", f"samples={samples}").stdout)

    def test_a_changed_input_is_said_when_a_run_is_repeated(self):
        samples = self.small_samples()
        self.run_ok("run", GRAPHS / "box.json", "--quiet", "--set", f"samples={samples}", "--set", "out=one.exr")
        make = (self.path / "make.json").read_text()
        self.document(make.replace('"spp": 2', '"spp": 3'), "make.json")
        self.run_ok("run", "make.json", "--quiet")
        done = self.run_ok("run", "one.exr", "--quiet", "--set", "out=two.exr")
        self.assertIn("small.npz: has changed since one.exr was made", done.stderr)

    def test_every_stage_can_be_swapped(self):
        common = ["--quiet", "--set", f"samples={self.small_samples()}", "--set", "locations=4"]
        self.run_ok("run", GRAPHS / "tlfr.json", *common, "--set", "out=as-it-is.exr")
        for swap in ("hierarchy=grid-hierarchy", "locations=random-locations", "reproject=reproject-nearest", "surfaces=depth-gap-cluster",
                     "coverage=hull-coverage", "coverage=nearest-surface", "filter=gaussian-visible", "filter=nearest-visible",
                     "picture=robust-accumulate"):
            self.run_ok("run", GRAPHS / "tlfr.json", *common, "--swap", swap, "--set", "out=swapped.exr")
            self.assertNotEqual((self.path / "as-it-is.exr").read_bytes(), (self.path / "swapped.exr").read_bytes(), swap)
            table = json.loads(self.run_ok("compare", "swapped.exr", "as-it-is.exr", "--json").stdout)
            self.assertLess(table[0]["rmse"], 1, swap)
        done = weft("run", GRAPHS / "tlfr.json", *common, "--set", "out=c.exr", "--swap", "surfaces=depth-gap-clutser", cwd=self.path)
        self.assertEqual(done.returncode, 2)
        self.assertIn("did you mean 'depth-gap-cluster'?", done.stderr)

    def test_a_node_is_bypassed(self):
        samples = self.small_samples()
        arguments = ["run", GRAPHS / "box.json", "--quiet", "--set", f"samples={samples}", "--set", "display.view=Un-tone-mapped"]
        self.run_ok(*arguments, "--set", "out=a.exr")
        self.run_ok(*arguments, "--set", "out=b.exr", "--bypass", "display")
        self.assertEqual((self.path / "a.exr").read_bytes()[:4], (self.path / "b.exr").read_bytes()[:4])
        self.assertNotEqual((self.path / "a.png").read_bytes(), (self.path / "b.png").read_bytes())
        done = weft("run", GRAPHS / "box.json", "--bypass", "filter", cwd=self.path)
        self.assertEqual(done.returncode, 2)
        self.assertIn("filter", done.stderr)

    def test_pictures_are_compared(self):
        samples = self.small_samples()
        self.run_ok("run", GRAPHS / "box.json", "--quiet", "--set", f"samples={samples}", "--set", "out=a.exr")
        table = json.loads(self.run_ok("compare", "a.exr", "a.exr", "--json").stdout)
        self.assertEqual(table[0]["relmse"], 0)
        self.run_ok("compare", "a.exr", "a.exr", "--error", "e.png")
        self.assertTrue((self.path / "e.png").exists())

    def test_no_configuration_of_colours_is_needed_and_a_wrong_one_is_named(self):
        samples = self.small_samples()
        environment = {k: v for k, v in os.environ.items() if k != "OCIO"}
        arguments = ("run", GRAPHS / "box.json", "--quiet", "--set", f"samples={samples}", "--set", "out=a.exr")
        self.assertEqual(weft(*arguments, cwd=self.path, env=environment).returncode, 0)
        done = weft(*arguments, cwd=self.path, env={**environment, "OCIO": "/nowhere/config.ocio"})
        self.assertEqual(done.returncode, 1)
        self.assertIn("/nowhere/config.ocio", done.stderr)
        done = weft(*arguments, "--set", "display.view=Sepia", cwd=self.path, env=environment)
        self.assertEqual(done.returncode, 1)
        self.assertIn("Un-tone-mapped", done.stderr)

    def test_scenes_are_known_by_name(self):
        environment = dict(os.environ, WEFT_SCENES=str(self.path / "scenes"))
        done = subprocess.run([os.path.join(os.environ["SOURCE"], "tools", "scenes"), "castle"], capture_output=True, text=True,
                              env=environment)
        self.assertEqual(done.returncode, 1)
        self.assertIn("no scene 'castle'; known: room, sterngarten, dungeon", done.stderr)

    def test_heavy_libraries_are_not_linked(self):
        linked = subprocess.run(["ldd", WEFT], capture_output=True, text=True, check=True).stdout
        self.assertNotIn("libOpenImageIO", linked)
        self.assertNotIn("libhwy", linked)


if __name__ == "__main__":
    unittest.main()
