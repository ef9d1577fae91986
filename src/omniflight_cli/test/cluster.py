"""A Slurm cluster of two emulated nodes on this machine: munged, slurmctld and two slurmd of Debian, in a folder of its own.

Example: with Cluster(pathlib.Path("/tmp/cluster")) as cluster: subprocess.run(["sinfo"], env=cluster.environment())
"""

import getpass
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo")
NODES = ("node1", "node2")

# One processor a node, so that one task runs on each. A controller without accounting, as small clusters have it.
CONFIGURATION = """ClusterName=omniflight_test
SlurmctldHost=localhost
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmctldPort={controller}
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
ReturnToService=0
SchedulerType=sched/builtin
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SlurmdTimeout=300
KillWait=5
{nodes}
PartitionName=flights Nodes={names} Default=YES MaxTime=60 State=UP
"""


def missing():
    """Names of programs that a cluster needs and that are not installed."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    return [name for name in PROGRAMS if shutil.which(name, path=path) is None]


def free_ports(count):
    """Ports that nobody listens on; all are held until the last is found."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for s in sockets:
            s.bind(("127.0.0.1", 0))
        return [s.getsockname()[1] for s in sockets]
    finally:
        for s in sockets:
            s.close()


def processes(wanted):
    """Process ids whose environment, given as {name: value}, fits `wanted`."""
    found = []
    for folder in pathlib.Path("/proc").iterdir():
        if not folder.name.isdigit() or int(folder.name) == os.getpid():
            continue
        try:
            words = (folder / "environ").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        environment = dict(word.split("=", 1) for word in words if "=" in word)
        if all(environment.get(name) == value for name, value in wanted.items()):
            found.append(int(folder.name))
    return found


def parent(pid):
    try:
        return int(pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[1])
    except OSError:
        return 0


def command(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/cmdline").read_text(errors="replace")
    except OSError:
        return ""


class Cluster:
    def __init__(self, folder):
        self.folder = folder
        self.daemons = {}

    def environment(self):
        return {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf"),
                "PATH": os.environ.get("PATH", "") + ":/usr/sbin:/sbin"}

    def start(self, name, *command):
        log = open(self.folder / f"{name}.log", "ab")
        with log:
            self.daemons[name] = subprocess.Popen(command, env=self.environment(), stdin=subprocess.DEVNULL, stdout=log,
                                                  stderr=log, start_new_session=True)

    def run(self, *command, timeout=30):
        return subprocess.run(command, env=self.environment(), text=True, capture_output=True, timeout=timeout)

    def __enter__(self):
        self.folder.mkdir(mode=0o700)
        (self.folder / "state").mkdir()
        (self.folder / "munge.key").write_bytes(os.urandom(1024))
        (self.folder / "munge.key").chmod(0o600)
        controller, *ports = free_ports(1 + len(NODES))
        nodes = "\n".join(f"NodeName={name} NodeHostname=localhost NodeAddr=127.0.0.1 Port={port} CPUs=1 RealMemory=500"
                          for name, port in zip(NODES, ports))
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            folder=self.folder, controller=controller, user=getpass.getuser(), nodes=nodes, names=",".join(NODES)))
        try:
            self.start("munged", "munged", "--foreground", "--force", f"--socket={self.folder}/munge.socket",
                       f"--key-file={self.folder}/munge.key", f"--pid-file={self.folder}/munged.pid",
                       f"--seed-file={self.folder}/munge.seed", f"--log-file={self.folder}/munged.log")
            self.wait("munged", lambda: (self.folder / "munge.socket").exists())
            self.start("slurmctld", "slurmctld", "-D", "-f", str(self.folder / "slurm.conf"))
            for node in NODES:
                self.start(node, "slurmd", "-D", "-f", str(self.folder / "slurm.conf"), "-N", node)
            self.wait("two idle nodes", lambda: self.run("sinfo", "-h", "-N", "-o", "%t").stdout.split() == ["idle"] * 2)
        except BaseException:
            self.__exit__()
            raise
        return self

    def wait(self, what, condition, timeout=60):
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                logs = "\n".join(p.read_text(errors="replace")[-1000:] for p in sorted(self.folder.glob("*.log")))
                raise AssertionError(f"waited {timeout} s for {what}\n{logs}")
            time.sleep(0.1)

    def kill_node(self, name):
        """As when its power fails: the daemon and all that runs on it are gone at once; then the controller is told."""
        self.daemons[name].kill()
        self.daemons[name].wait(timeout=10)
        tasks = processes({"SLURM_CONF": str(self.folder / "slurm.conf"), "SLURMD_NODENAME": name})
        # first those that would tell the controller how their tasks ended
        for pid in [p for p in map(parent, tasks) if command(p).startswith("slurmstepd")] + tasks:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        done = self.run("scontrol", "update", f"nodename={name}", "state=down", "reason=killed")
        if done.returncode != 0:
            raise AssertionError(done.stderr)

    def __exit__(self, *_):
        if "slurmctld" in self.daemons:
            try:
                self.run("scancel", f"--user={getpass.getuser()}", timeout=20)
            except subprocess.TimeoutExpired:
                pass
        for daemon in self.daemons.values():
            daemon.terminate()
        for daemon in self.daemons.values():
            try:
                daemon.wait(timeout=10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait(timeout=10)
        for pid in processes({"SLURM_CONF": str(self.folder / "slurm.conf")}):  # what ran on the nodes
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
