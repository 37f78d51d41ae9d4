#!/usr/bin/env python3
"""A sweep through a real Slurm, one node on this machine: slurm_test.py BUILD_DIR SOURCE_DIR

Starts munge, slurmctld and slurmd of its own, in a folder of its own, and ends them. Skipped (77) where they are not
installed, and for who is not root, whom slurmd does not serve.
"""
import os
import pathlib
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time

import by_hand

BUILD, SOURCE = by_hand.arguments("build", "source")
SEAM = BUILD / "seam"
LIMIT_S = 300
SHARDS = 3
HOST = socket.gethostname().split(".")[0]


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def slurm_conf(here):
    return f"""ClusterName=seam
SlurmctldHost={HOST}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={here}/munge.socket
StateSaveLocation={here}/state
SlurmdSpoolDir={here}/spool
SlurmctldPidFile={here}/slurmctld.pid
SlurmdPidFile={here}/slurmd.pid
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
NodeName={HOST} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class Cluster:
    """Its daemons, while it lives."""

    def __init__(self, here):
        for name in ("state", "spool"):
            (here / name).mkdir()
        (here / "slurm.conf").write_text(slurm_conf(here))
        key = here / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o400)
        self.environment = dict(os.environ, SLURM_CONF=str(here / "slurm.conf"))
        self.log = (here / "daemons.txt").open("w")
        self.daemons = []
        self.start("munged", "--foreground", "--force", f"--socket={here}/munge.socket", f"--key-file={key}",
                   f"--pid-file={here}/munged.pid", f"--log-file={here}/munged.log", f"--seed-file={here}/munged.seed")
        self.wait(lambda: (here / "munge.socket").exists(), "munged")
        self.start("slurmctld", "-D")
        self.start("slurmd", "-D", "-N", HOST)
        self.wait(lambda: "idle" in self.ask("sinfo", "-h", "-o", "%t"), "the node")

    def start(self, *command):
        self.daemons.append(subprocess.Popen(command, stdout=self.log, stderr=subprocess.STDOUT, env=self.environment))

    def ask(self, *command):
        return subprocess.run(command, capture_output=True, text=True, env=self.environment, timeout=LIMIT_S).stdout

    def wait(self, ready, what):
        end = time.monotonic() + LIMIT_S / 2
        while not ready():
            assert time.monotonic() < end, f"waited in vain for {what}"
            time.sleep(0.2)

    def end(self):
        for daemon in reversed(self.daemons):
            daemon.terminate()
            daemon.wait(30)
        self.log.close()


def run(here, environment, *arguments):
    done = subprocess.run([SEAM, *map(str, arguments)], capture_output=True, text=True, timeout=LIMIT_S, cwd=here, env=environment)
    assert done.returncode == 0, (arguments, done.stdout, done.stderr)
    return done.stdout


def main():
    missing = [name for name in ("munged", "slurmctld", "slurmd", "sbatch") if shutil.which(name) is None]
    if missing or os.geteuid() != 0:
        print(f"skipped: {', '.join(missing) or 'not root'}")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        here = pathlib.Path(folder)
        here.chmod(0o755)
        cluster = Cluster(here)
        try:
            plan = SOURCE / "scenarios" / "sweep.yaml"
            print(run(here, cluster.environment, "sweep", "submit", plan, "--slurm", "--shards", SHARDS, "--jobs", 1, "--out", "r.sqlite"))
            cluster.wait(lambda: (here / "r.sqlite").exists() and not cluster.ask("squeue", "-h").strip(), "the jobs")
            run(here, cluster.environment, "sweep", "merge", *[f"r.sqlite.shards/shard_{i + 1}.sqlite" for i in range(SHARDS)],
                "--out", "again.sqlite")
            run(here, cluster.environment, "sweep", plan, "--out", "here.sqlite")
            tables = [run(here, cluster.environment, "sweep", "table", name) for name in ("r.sqlite", "again.sqlite", "here.sqlite")]
            assert tables[0] == tables[1] == tables[2], tables
        except AssertionError:
            for file in (*here.glob("r.sqlite.shards/slurm-*"), here / "daemons.txt"):
                print(f"{file.name}:\n{file.read_text()[-2000:]}")
            raise
        finally:
            cluster.end()
    print(f"ok: {SHARDS} tasks and a merge through Slurm give the table of one sweep")
    return 0


if __name__ == "__main__":
    sys.exit(main())
