"""A Slurm of one node, from Debian's packages, in a temporary folder: its own munge, slurmctld and slurmd, ended with the block.

    with SlurmNode() as slurm:
        subprocess.run(["sbatch", ...], env=slurm.environment)

    python3 tests/scripts/slurm_node.py COMMAND...      runs a command within it, such as `arkmesh batch FILE --slurm`
"""
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time

PROGRAMS = ("munged", "mungekey", "slurmctld", "slurmd", "sbatch", "squeue", "sinfo")

CONFIG = """ClusterName=arkmesh_test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmdPort={node_port}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,batch_sched_delay=0
ReturnToService=2
MpiDefault=none
SwitchType=switch/none
MinJobAge=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """Why there can be no Slurm here, in one sentence; empty when there can."""
    absent = [name for name in PROGRAMS if not shutil.which(name, path=search_path())]
    if absent:
        return f"{', '.join(absent)} not installed (scripts/setup test installs slurmctld, slurmd, slurm-client and munge)"
    return "" if os.geteuid() == 0 else "slurmd runs as root only"


def search_path():
    return os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class SlurmNode:
    def __init__(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="slurm.")
        self.folder = pathlib.Path(self.scratch.name)
        self.environment = os.environ | {"PATH": search_path(), "SLURM_CONF": str(self.folder / "slurm.conf")}
        self.processes = []

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        # Slurm resolves no address where a machine has none but 127.0.0.1, as in scripts/alone's network
        if not self.run("ip", "-oneline", "address", "show", "scope", "global").stdout:
            self.run("ip", "address", "add", "192.0.2.1/32", "dev", "lo")
        # munge trusts no folder that others may write
        os.chmod(self.folder, 0o755)
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        host = socket.gethostname().split(".")[0]
        config = CONFIG.format(host=host, folder=self.folder, port=free_port(), node_port=free_port(), cpus=os.cpu_count())
        (self.folder / "slurm.conf").write_text(config)
        self.run("mungekey", "--create", "--keyfile", self.folder / "munge.key")
        self.spawn("munged", "--foreground", "--force", "--key-file", self.folder / "munge.key", "--socket", self.folder / "munge.socket",
                   "--pid-file", self.folder / "munge.pid", "--log-file", self.folder / "munge.log", "--seed-file", self.folder / "munge.seed")
        self.wait(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.spawn("slurmctld", "-D")
        self.spawn("slurmd", "-D", "-N", host)
        self.wait(lambda: "idle" in self.run("sinfo", "--noheader", "--format=%T", check=False).stdout, "the node")

    def spawn(self, name, *arguments):
        with open(self.folder / f"{name}.said", "wb") as said:
            self.processes.append(subprocess.Popen([shutil.which(name, path=search_path()), *map(str, arguments)], env=self.environment,
                                                   stdin=subprocess.DEVNULL, stdout=said, stderr=subprocess.STDOUT, start_new_session=True))

    def run(self, name, *arguments, check=True):
        return subprocess.run([name, *map(str, arguments)], env=self.environment, capture_output=True, text=True, timeout=30, check=check)

    def wait(self, condition, what, seconds=60):
        deadline = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > deadline:
                logs = "".join(f"--- {file.name}\n{file.read_text(errors='replace')[-2000:]}\n" for file in self.folder.glob("*.said"))
                raise RuntimeError(f"{what} did not come up within {seconds} s\n{logs}")
            time.sleep(0.1)

    def stop(self):
        for process in reversed(self.processes):
            process.terminate()
        for process in reversed(self.processes):
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.scratch.cleanup()


def main(command):
    if not command or command[0].startswith("-"):
        raise SystemExit(__doc__.strip())
    if missing():
        raise SystemExit(f"slurm_node: {missing()}")
    with SlurmNode() as slurm:
        raise SystemExit(subprocess.run(command, env=slurm.environment).returncode)


if __name__ == "__main__":
    main(sys.argv[1:])
