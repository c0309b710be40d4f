#!/usr/bin/env python3
"""Processor time of a study in one process beside that of the same study in shards, on a cluster by Slurm and over ssh.

    ./firn bench study_shards [--study STUDY] [--shards 40] [--chunk 60] [--ways shards,slurm,ssh] [OPTION of firn compare…]

The default is the README's study of schemes, 1,000 prints. Slurm has two virtual nodes on loopback, one of which is killed with all
its tasks in the middle of the array and comes back; ssh are two daemons on loopback. The time is that of everything that was
started, the daemons included. Each way must give the bytes of the study in one piece; the exit status is 1 where one does not.
"""
import argparse
import ctypes
import filecmp
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from loopback_hosts import Cluster, Hosts  # noqa: E402

FIRN = ROOT / "build" / "bin" / "firn"
RESULTS = ("runs.csv", "summary.json", "report.html")
PR_SET_CHILD_SUBREAPER = 36
PATIENCE_S = 3600


def measured(work):
    """Wall and processor time of all that `work` starts, orphans too, and what it returns."""
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
        began = time.monotonic()
        code = 1
        try:
            said = work()
            wall = time.monotonic() - began
            while True:
                try:
                    os.wait()
                except ChildProcessError:
                    break
            used = resource.getrusage(resource.RUSAGE_CHILDREN)
            os.write(writer, json.dumps([wall, used.ru_utime + used.ru_stime, said]).encode())
            code = 0
        finally:
            os._exit(code)
    os.close(writer)
    with os.fdopen(reader, "rb") as told:
        answer = told.read()
    if os.waitpid(pid, 0)[1] != 0:
        sys.exit("study_shards: the study failed")
    return json.loads(answer)


class Study:
    def __init__(self, study, options, scratch):
        self.words, self.scratch = [str(FIRN), "compare", str(study), *options], scratch

    def run(self, out, *more, env=None, **how):
        with open(self.scratch / f"{out}.said", "ab") as said:
            return subprocess.run([*self.words, "-o", str(self.scratch / out), *more], env=env, stdout=said, stderr=said, check=True, **how)

    def start(self, out, *more, env=None):
        with open(self.scratch / f"{out}.said", "ab") as said:
            return subprocess.Popen([*self.words, "-o", str(self.scratch / out), *more], env=env, stdout=said, stderr=said)

    def lines(self, out):
        """Lines of the journals: cheaper than --status, whose time would count."""
        return sum(journal.read_bytes().count(b"\n") for journal in (self.scratch / out / "shards").glob("*"))

    def prints_s(self, out):
        """Processor time of the prints themselves, as the journals have it: it grows with the load of the computer."""
        return sum(float(s) for journal in (self.scratch / out).rglob("*.journal") for s in re.findall(r'"cpu_s":([0-9.e+-]+)', journal.read_text()))

    def same_bytes(self, out):
        return len(filecmp.cmpfiles(self.scratch / "one", self.scratch / out, RESULTS, shallow=False)[0]) == len(RESULTS)


def wait_until(holds, what, pause_s=1):
    end = time.monotonic() + PATIENCE_S
    while not holds():
        if time.monotonic() > end:
            raise RuntimeError(f"{what}: not within {PATIENCE_S} s")
        time.sleep(pause_s)


def in_shards(study, shards, _chunk):
    for k in range(1, shards + 1):
        study.run("shards", "--shard", f"{k}/{shards}", "--threads", "1")
    study.run("shards", "--threads", "1")
    return f"{shards} shards"


def on_slurm(study, _shards, chunk):
    with tempfile.TemporaryDirectory() as place:
        cluster = Cluster(place)
        try:
            waiting = study.start("slurm", "--on", "slurm", "--chunk", str(chunk), "--threads", "1", env=cluster.env)
            running = lambda: cluster.slurm("squeue", "--noheader", "--nodelist=n2", "--states=RUNNING", "-o", "%i").split()  # noqa: E731
            wait_until(running, "a task on the second node")
            wait_until(lambda: study.lines("slurm") > 20, "prints")
            killed = running()
            cluster.kill_node("n2")
            cluster.start_node("n2")

            def over():
                for task in cluster.slurm("squeue", "--noheader", "--array", "-o", "%i %r").splitlines():
                    if "BeginTime" in task:  # Slurm holds back what it starts again for two minutes
                        cluster.slurm("scontrol", "update", f"JobId={task.split()[0]}", "StartTime=now")
                return waiting.poll() is not None

            wait_until(over, "the study", pause_s=10)  # squeue's time counts too
            if waiting.returncode != 0:
                raise RuntimeError(f"firn compare --on slurm: exit code {waiting.returncode}")
        finally:
            cluster.stop()
    tasks = json.loads((study.scratch / "slurm" / "slurm" / "job.json").read_text())["tasks"]
    return f"{tasks} tasks of {chunk:g} s, node n2 killed with task {', '.join(killed)}"


def over_ssh(study, _shards, chunk):
    with tempfile.TemporaryDirectory() as place:
        hosts = Hosts(place, ["alpha", "beta"])
        try:
            study.run("ssh", "--on", "ssh:1/alpha,1/beta", "--chunk", str(chunk), "--threads", "1", env=hosts.env)
        finally:
            hosts.stop()
    log = (study.scratch / "ssh" / "parallel" / "job.log").read_text().splitlines()
    return f"{len(log) - 1} shards of {chunk:g} s over ssh"


WAYS = {"shards": in_shards, "slurm": on_slurm, "ssh": over_ssh}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--study", default=ROOT / "experiments" / "studies" / "schemes.toml")
    parser.add_argument("--shards", type=int, default=40)
    parser.add_argument("--chunk", type=float, default=60.0)
    parser.add_argument("--ways", default=",".join(WAYS))
    asked, options = parser.parse_known_args()
    ways = asked.ways.split(",")
    if unknown := [w for w in ways if w not in WAYS]:
        parser.error(f"--ways: {', '.join(unknown)}: must be of {', '.join(WAYS)}")
    good = True
    with tempfile.TemporaryDirectory() as folder:
        study = Study(asked.study, options, Path(folder))
        wall, one, _ = measured(lambda: study.run("one", "--threads", "1") and "")
        alone = one / study.prints_s("one")
        print(f"{'one process':<12} {one:8.1f} s of processor time, {wall:6.0f} s of wall time; {alone:.3f} of the prints' own", flush=True)
        for name in ways:
            wall, cpu, said = measured(lambda way=WAYS[name]: way(study, asked.shards, asked.chunk))
            same = study.same_bytes(name)
            good = good and same
            share = cpu / study.prints_s(name)
            print(f"{name:<12} {cpu:8.1f} s of processor time, {wall:6.0f} s of wall time; {share:.3f} of the prints' own, "
                  f"{100 * (share / alone - 1):+.1f} %, {'same bytes' if same else 'OTHER BYTES'}: {said}", flush=True)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
