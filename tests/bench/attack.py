#!/usr/bin/env python3
"""Attacks on runs and their commands: see attack.sh."""
import argparse
import functools
import os
import random
import resource
import shutil
import signal
import socket
import stat
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from attack_live import LiveAttack

ROOT = Path(__file__).resolve().parents[2]
PRINT = ["print", str(ROOT / "experiments" / "cylinder.toml"), "--set", "part.height_mm=0.1"]
PATIENCE_S = 120
MOST_MEMORY = 100e6  # bytes that a crafted folder may take more than an honest one, beside pages of its files

# Commands that touch a run, by name; RUN is its folder. The third is whether it writes into the run.
COMMANDS = {
    "resume": (["print", "--resume", "RUN", "--bus", "in-process"], True),
    "pack": (["runs", "pack", "RUN"], True),
    "expand": (["runs", "expand", "RUN"], True),
    "repair": (["log", "repair", "RUN/log.lcm"], True),
    "audit": (["audit", "RUN"], False),
    "replay": (["replay", "RUN"], False),
    "report": (["report", "RUN", "--no-replay", "-o", "RUN.html"], False),
    "export": (["export", "RUN", "-o", "RUN.npz"], False),
    "clean": (["runs", "clean", "--runs", "RUN/..", "--keep", "0", "--yes"], True),
}


class Attack(LiveAttack):
    def __init__(self, firn, seed, folder):
        self.firn, self.random, self.folder = firn, random.Random(seed), folder
        self.build, self.commands = Path(firn).parents[1], COMMANDS
        self.stopped, self.worlds = None, {}
        self.rows, self.failures, self.figures = {}, [], {}
        self.took_s, self.honest = {}, {}  # of each command on an honest run: seconds, bytes

    # ------------------------------------------------------------------------------------------------ runs and commands
    @functools.cached_property
    def finished(self):
        return self.printed("finished")

    @functools.cached_property
    def broken_off(self):
        return self.printed("broken-off", layers=6)

    def printed(self, name, layers=None):
        """A finished run, or one that was killed after so many layers."""
        place = self.folder / name
        place.mkdir()
        more = [] if layers is None else ["--plain"]
        process = self.start([*PRINT, "--bus", "in-process", "--runs", str(place), *more])
        while layers is not None and process.poll() is None:
            metrics = list(place.glob("*/metrics.csv")) + list(place.glob("*/nodes/scheduler.wal"))
            if any(f.stat().st_size > layers * 1500 for f in metrics):
                process.kill()
        process.communicate(timeout=PATIENCE_S)
        [run] = place.iterdir()
        return run

    def start(self, words, **more):
        return subprocess.Popen([self.firn, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                errors="replace", cwd=self.folder, start_new_session=True, **more)

    def command(self, name, run):
        return [word.replace("RUN", str(run)) for word in COMMANDS[name][0]]

    def end_of(self, process):
        """(exit code, output) of a command; code None: it hung."""
        try:
            output, _ = process.communicate(timeout=PATIENCE_S)
            return process.returncode, output
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return None, process.communicate()[0]

    def done(self, name, run):
        return self.done_words(self.command(name, run))

    def done_words(self, words):
        return self.end_of(self.start(words))

    def copy(self, run):
        place = Path(tempfile.mkdtemp(dir=self.folder))
        shutil.copytree(run, place / run.name, symlinks=True, ignore=shutil.ignore_patterns("operator"))
        return place / run.name

    def seconds(self, name, run):
        """How long a command takes on a copy of this run."""
        key = name, run.parent.name
        if key not in self.took_s:
            copy, began = self.copy(run), time.monotonic()
            self.done(name, copy)
            self.took_s[key] = time.monotonic() - began
            shutil.rmtree(copy.parent)
        return self.took_s[key]

    def tried(self, row, what, problems, figures=None):
        tries, failed = self.rows.get(row, (0, 0))
        self.rows[row] = tries + 1, failed + bool(problems)
        self.failures += [f"{row}: {what}: {p}" for p in problems]
        for name, value in (figures or {}).items():
            self.figures.setdefault((row, name), []).append(value)

    def left_out(self, row, why):
        self.rows.setdefault(row, (0, 0))
        print(f"{row}: left out: {why}", file=sys.stderr)

    def told(self, row):
        """The row of the table: tries, failures, and the largest and the middle of each figure."""
        tries, failed = self.rows.get(row, (0, 0))
        text = f"{row:10} {tries:6} tries, {failed} failed"
        for (of, name), values in self.figures.items():
            if of == row:
                text += f"; {name}: middle {sorted(values)[len(values) // 2]:.0f}, most {max(values):.0f}"
        return text

    # ------------------------------------------------------------------------------------------------------- invariants
    def crashed(self, name, code, output):
        if code is None:
            return [f"{name} hung"]
        if code < 0 or code > 4 or "terminate called" in output or "Sanitizer" in output:
            return [f"{name} ended with {code}: {output[-300:]}"]
        return []

    def lost(self, run):
        """Problems of a run after an attack: it can be finished, its audit is clean, its replay identical, nothing unfinished is left."""
        if not run.exists():
            return []
        problems = []
        code, output = self.done("resume", run)
        if code != 0 and "has finished" not in output:
            problems.append(f"it cannot go on, exit {code}: {output[-300:]}")
        for name, wanted in (("audit", "clean"), ("replay", "identical")):
            code, output = self.done(name, run)
            if code != 0 or wanted not in output:
                problems.append(f"{name} says, exit {code}: {output[-300:]}")
        left = [str(p.relative_to(run)) for p in run.rglob("*") if p.name.endswith((".packed", ".part"))]
        if left:
            problems.append(f"left behind: {left}")
        return problems

    # ---------------------------------------------------------------------------------------------------------- attacks
    def pairs(self):
        return [(self.pair, first, second) for first in COMMANDS for second in COMMANDS]

    def pair(self, first, second):
        base = self.random.choice((self.finished, self.broken_off))
        run, delay = self.copy(base), self.random.uniform(0, 1.1) * self.seconds(first, base)
        a = self.start(self.command(first, run))
        time.sleep(delay)
        b = self.start(self.command(second, run))
        ends = [(first, *self.end_of(a)), (second, *self.end_of(b))]
        problems = [p for end in ends for p in self.crashed(*end)]
        if not run.exists() and "clean" not in (first, second):
            problems.append("the run is gone")
        self.tried("pairs", f"{first}, {delay:.3f} s later {second} on a {base.parent.name} run", problems + self.lost(run))
        shutil.rmtree(run.parent)

    def kills(self):
        return [(self.kill, name) for name in [n for n, (_, writes) in COMMANDS.items() if writes] + ["print"]]

    def kill(self, name):
        how = self.random.choice((signal.SIGINT, signal.SIGTERM, signal.SIGKILL))
        if name == "print":
            place = Path(tempfile.mkdtemp(dir=self.folder))
            process, longest = self.start([*PRINT, "--bus", "in-process", "--runs", str(place)]), 1.5
        else:
            base = self.random.choice((self.finished, self.broken_off))
            run = self.copy(base)
            place, process, longest = run.parent, self.start(self.command(name, run)), self.seconds(name, base)
        delay = self.random.uniform(0, 1.1) * longest
        time.sleep(delay)
        if process.poll() is None:
            os.killpg(process.pid, how)
        self.end_of(process)
        problems = []
        for run in [r for r in place.iterdir() if (r / "provenance.json").exists() and (r / "nodes").exists()]:
            if name == "clean":  # a run that is half removed is none any more, and is removed by the next clean
                self.done("clean", run)
                problems += [] if not run.exists() else self.lost(run)
            else:
                problems += self.lost(run)
        self.tried("kills", f"{name} after {delay:.3f} s by {how.name}", problems)
        shutil.rmtree(place)

    def crafted(self):
        places = sorted(p.relative_to(self.finished) for p in self.finished.rglob("*") if p.is_file())
        # Places that a run may have besides.
        places += [Path(p) for p in ("notes.jsonl", "report.html", "seals/derived.seal", "lock", "io/lock", "operator", "metrics.csv", "print.out")]
        return [(self.craft, place, kind) for place in places for kind in ("link", "pipe", "device", "folder", "socket", "large")]

    def craft(self, place, kind):
        run = self.copy(self.finished)
        secret, target = run.parent / "secret", run / place
        secret.write_text("SECRET-" * 100)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.unlink(missing_ok=True)
        if kind == "link":
            target.symlink_to(secret)
        elif kind == "pipe":
            os.mkfifo(target)
        elif kind == "device":
            try:
                os.mknod(target, 0o666 | stat.S_IFCHR, os.makedev(1, 5))  # /dev/zero
            except PermissionError:
                target.symlink_to("/dev/zero")
        elif kind == "folder":
            target.mkdir()
        elif kind == "socket":
            with socket.socket(socket.AF_UNIX) as s:
                here = os.getcwd()
                os.chdir(target.parent)  # a socket's path is short
                s.bind(target.name)
                os.chdir(here)
        else:
            with open(target, "wb") as f:
                f.truncate(8 << 30)  # a hole of 8 GiB
        name = self.random.choice(("audit", "replay", "report", "export", "pack", "expand", "repair"))
        peak, code, output = self.watched(name, run)
        problems = self.crashed(name, code, output)
        if secret.read_text() != "SECRET-" * 100:
            problems.append("a file outside the run was written")
        made = [run.parent / (run.name + end) for end in (".html", ".npz")]
        if "SECRET" in output or any(m.exists() and b"SECRET" in m.read_bytes() for m in made):
            problems.append("a file outside the run was read")
        if name not in self.honest:
            honest = self.copy(self.finished)
            self.honest[name] = self.watched(name, honest)[0]
            shutil.rmtree(honest.parent)
        if peak > self.honest[name] + MOST_MEMORY:
            problems.append(f"{peak / 1e6:.0f} MB of memory")
        self.tried("crafted", f"{kind} at {place}, {name}", problems)
        shutil.rmtree(run.parent)

    def watched(self, name, run):
        """(most bytes of memory of its own, exit code, output) of a command, which is killed when it takes 2 GB."""
        process, peak = self.start(self.command(name, run)), 0
        while process.poll() is None and peak < 2e9:
            try:
                status = Path(f"/proc/{process.pid}/status").read_text()
            except OSError:
                break
            peak = max([peak] + [1024 * int(line.split()[1]) for line in status.splitlines() if line.startswith("RssAnon")])
            time.sleep(0.002)
        if process.poll() is None and peak >= 2e9:
            os.killpg(process.pid, signal.SIGKILL)
        return peak, *self.end_of(process)

    def idle(self):
        return [(self.crowd,)]

    def crowd(self):
        place = Path(tempfile.mkdtemp(dir=self.folder))
        process = self.start([*PRINT, "--runs", str(place)])
        until = time.monotonic() + 60
        while not (desks := list(place.glob("*/operator"))) and time.monotonic() < until:
            time.sleep(0.05)
        problems, guests, figures = [], [], {}
        if not desks:
            problems.append("the print did not begin")
        else:
            run, here = desks[0].parent, os.getcwd()
            os.chdir(run)  # a socket's path is short
            for _ in range(1000):
                guest = socket.socket(socket.AF_UNIX)
                guest.setblocking(False)
                try:
                    guest.connect("operator")
                except OSError:
                    pass
                guests.append(guest)
            os.chdir(here)
            began = time.monotonic()
            code, output = self.end_of(self.start(["ctl", str(run), "stop"]))
            answered = time.monotonic() - began
            if code != 0:
                problems.append(f"the stop was not obeyed, exit {code}: {output[-300:]}")
            figures["over after, ms"] = 1e3 * answered
        for guest in guests:
            guest.close()
        code, output = self.end_of(process)
        problems += self.crashed("print", code, output)
        for run in place.iterdir():
            problems += self.lost(run)
        self.tried("idle", "1,000 silent guests", problems, figures)
        shutil.rmtree(place)


KINDS = ("pairs", "kills", "crafted", "idle", "live", "stalls", "clocks", "disks", "forged", "floods")
ONCE = ("idle", "live", "disks", "forged")  # a live print each: one in a short draw
LONG = ("stalls", "clocks", "floods")  # in no short draw, unless they are asked for


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--draws", type=int, default=20, help="of every pair, command and place")
    arguments.add_argument("--sample", type=int, help="only so many tries of each kind")
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--only", choices=KINDS)
    arguments.add_argument("--firn", default=str(ROOT / "build" / "bin" / "firn"))
    given = arguments.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    with tempfile.TemporaryDirectory(prefix="firn-attack-") as folder:
        attack = Attack(str(Path(given.firn).resolve()), given.seed, Path(folder))
        for kind in KINDS:
            if given.only not in (None, kind) or (given.sample and not given.only and kind in LONG):
                continue
            tries = getattr(attack, kind)() * (1 if kind == "idle" else given.draws)
            attack.random.shuffle(tries)
            tries = tries[:1 if given.sample and kind in ONCE + LONG else given.sample]
            try:
                for n, (attempt, *what) in enumerate(tries):
                    attempt(*what)
                    if sys.stderr.isatty():
                        print(f"\r{kind}: {n + 1} of {len(tries)}", end="\r", file=sys.stderr, flush=True)
            finally:  # of a bench that is ended too
                failures = [f for f in attack.failures if f.startswith(kind + ":")]
                print(attack.told(kind), *failures, sep="\n", flush=True)
    return bool(attack.failures)


if __name__ == "__main__":
    sys.exit(main())
