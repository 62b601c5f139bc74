"""A Slurm of one node on loopback, of the test's own: all its files lie in one folder, its ports are free ones.

Needs root and the packages slurmctld, slurmd, slurm-client and munge; why_not() says what is missing.
"""
import os
import pathlib
import shutil
import socket
import subprocess
import time


def why_not():
    missing = [name for name in ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel")
               if not shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")]
    if missing:
        return "not installed: " + ", ".join(missing)
    if os.geteuid() != 0:
        return "starting a Slurm of its own needs root"
    if not os.path.ismount("/sys/fs/cgroup"):
        return "slurmd needs cgroups, and /sys/fs/cgroup is not mounted"
    return None


def free_ports(count):
    held = [socket.socket() for _ in range(count)]
    for one in held:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in held]
    for one in held:
        one.close()
    return ports


class Slurm:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.processes = []

    def start(self):
        for name in ("state", "spool", "munge"):
            (self.folder / name).mkdir(mode=0o700)
        (self.folder / "munge/key").write_bytes(os.urandom(1024))
        (self.folder / "munge/key").chmod(0o400)
        host = socket.gethostname().split(".")[0]
        control, node = free_ports(2)
        conf = self.folder / "slurm.conf"
        conf.write_text(f"""
ClusterName=weft
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
# A job queued again waits until its old credential has expired: 120 s, were it not said.
AuthInfo=socket={self.folder}/munge/socket,cred_expire=5
CredType=cred/munge
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
SlurmdParameters=config_overrides
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_min_interval=100000,batch_sched_delay=1
KillWait=3
InactiveLimit=0
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=500
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        self.environment = {**os.environ, "SLURM_CONF": str(conf)}
        self._spawn("munged", "--foreground", "--force", f"--key-file={self.folder}/munge/key", f"--socket={self.folder}/munge/socket",
                    f"--pid-file={self.folder}/munge/pid", f"--log-file={self.folder}/munge/log", f"--seed-file={self.folder}/munge/seed")
        self._wait_for(lambda: (self.folder / "munge/socket").exists(), "munged")
        self._spawn("slurmctld", "-D", "-f", str(conf))
        self._spawn("slurmd", "-D", "-f", str(conf))
        self._wait_for(lambda: self.run("sinfo", "-h", "-o", "%T").stdout.strip() == "idle", "the node to be idle")
        return self

    def run(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, timeout=60)

    def stop(self):
        self.run("scancel", "--full", "-u", "root")
        for process in reversed(self.processes):
            process.terminate()
        for process in reversed(self.processes):
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def _spawn(self, name, *arguments):
        program = shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")
        log = open(self.folder / f"{name}.log", "ab")
        self.processes.append(subprocess.Popen([program, *arguments], env=getattr(self, "environment", None), stdout=log, stderr=log,
                                               stdin=subprocess.DEVNULL, cwd=self.folder))
        log.close()

    def _wait_for(self, ready, what):
        end = time.monotonic() + 60
        while not ready():
            if time.monotonic() > end:
                said = "".join(f"--- {p.name}\n{p.read_text(errors='replace')[-2000:]}\n" for p in self.folder.glob("*.log"))
                self.stop()
                raise RuntimeError(f"waited a minute for {what}\n{said}")
            time.sleep(0.2)
