"""A real Slurm of one controller and two nodes, on loopback, without systemd, munge or accounting."""

import os
import shutil
import socket
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

import psutil

PROGRAMS = ["slurmctld", "slurmd", "sbatch", "squeue", "srun", "sinfo", "scontrol"]
SBIN = os.pathsep.join(["/usr/sbin", "/sbin"])
CONF = """\
ClusterName=freerock_test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool_%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd_%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd_%n.log
SlurmdTimeout=10
ReturnToService=2
MinJobAge=3600
KillWait=2
PropagateResourceLimits=NONE
NodeName=n1 NodeAddr=127.0.0.1 NodeHostname={host} Port={ports[1]} CPUs=1 RealMemory=4000
NodeName=n2 NodeAddr=127.0.0.1 NodeHostname={host} Port={ports[2]} CPUs=1 RealMemory=4000
PartitionName=test Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""
# Runs a daemon and adopts whatever leaves it: all that runs on a node is found below one process.
ADOPT = """\
import ctypes, os, subprocess, sys
ctypes.CDLL(None).prctl(36, 1)  # PR_SET_CHILD_SUBREAPER
subprocess.Popen(sys.argv[1:])
while True:
    try:
        os.wait()
    except ChildProcessError:
        break
"""


def missing() -> list:
    """What is not installed: programs of Slurm, Snakemake's plugin."""
    path = os.environ["PATH"] + os.pathsep + SBIN
    plugin = [] if find_spec("snakemake_executor_plugin_slurm") else ["the plugin (make slurm)"]
    return [name for name in PROGRAMS if not shutil.which(name, path=path)] + plugin


class Slurm:
    """A running Slurm; `environment` is that of its clients."""

    def __init__(self, folder: Path):
        self.folder, self.conf, self.daemons = folder, folder / "slurm.conf", {}
        host = socket.gethostname().partition(".")[0]
        with ExitStack() as stack:
            sockets = [stack.enter_context(socket.socket()) for _ in range(3)]
            for each in sockets:
                each.bind(("127.0.0.1", 0))
            ports = [each.getsockname()[1] for each in sockets]
        (folder / "state").mkdir()
        user = psutil.Process().username()
        self.conf.write_text(CONF.format(host=host, ports=ports, user=user, folder=folder))
        # The job step forgets SLURM_CONF; an srun that knows it stands before the installed one.
        (folder / "bin").mkdir()
        srun = folder / "bin/srun"
        srun.write_text(f'#!/bin/sh\nSLURM_CONF={self.conf} exec {shutil.which("srun")} "$@"\n')
        srun.chmod(0o755)
        path = os.pathsep.join([str(folder / "bin"), os.environ["PATH"], SBIN])
        self.environment = {"SLURM_CONF": str(self.conf), "PATH": path}

    def start(self, name: str, *command: str) -> None:
        with open(self.folder / f"{name}.out", "a") as out:
            self.daemons[name] = subprocess.Popen(
                [sys.executable, "-c", ADOPT, *command],
                env=os.environ | self.environment,
                cwd=self.folder,
                stdout=out,
                stderr=out,
            )

    def start_node(self, name: str) -> None:
        self.start(name, "slurmd", "-D", "-N", name, "-f", str(self.conf))

    def kill(self, name: str) -> None:
        """Kill a daemon with everything that runs below it, at once, as a power cut does."""
        daemon = self.daemons.pop(name)
        while daemon.poll() is None:  # it ends when nothing is left below it
            for process in psutil.Process(daemon.pid).children(recursive=True):
                with suppress(psutil.NoSuchProcess):
                    process.kill()
            time.sleep(0.02)

    def ask(self, *command: str) -> str:
        """What a client of Slurm answers, "" where it fails."""
        environment = os.environ | self.environment
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60).stdout

    def jobs(self, *states: str) -> list:
        """Nodes of the jobs in these states, or of all that ever ran."""
        told = self.ask("squeue", "--noheader", f"--states={','.join(states) or 'all'}", "--format=%N")
        return told.split()

    def wait_for(self, condition, seconds: float) -> None:
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(self.ask("sinfo", "-N", "-l") + self.ask("squeue", "--states=all"))
            time.sleep(0.2)


@contextmanager
def slurm(folder: Path):
    """A Slurm of the nodes n1 and n2, stopped at the end with all its jobs."""
    cluster = Slurm(folder)
    try:
        cluster.start("controller", "slurmctld", "-D", "-f", str(cluster.conf))
        for node in ("n1", "n2"):
            cluster.start_node(node)
        cluster.wait_for(lambda: cluster.ask("sinfo", "-h", "-N", "-o", "%T").split() == ["idle"] * 2, 30)
        yield cluster
    finally:
        for name in list(cluster.daemons):
            cluster.kill(name)
