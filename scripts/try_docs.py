#!/usr/bin/env python3
"""Gives every command of README.md and docs/ as a new user would: page by page, on an empty Debian 12 after ./firn demo.

    scripts/try_docs.py [PAGE]... [--machine FOLDER] [--kept FOLDER] [--at FOLDER] [--cold] [--limit S] [--test]
    scripts/try_docs.py --list [PAGE]...

Prints a row of CSV for each command: page, line, command, exit code, seconds, processor seconds (on a busy computer half of them
are about what two idle cores would take), packages that it installed, MB that it downloaded, MB of build/ and of the whole machine
afterwards, and what is wrong. Exits with 1 if a command ended otherwise than its
page says, with 3 where no fresh machine can be had. scripts/doc_commands.py says what counts as a command, and which are left out.

--machine FOLDER   an empty Debian 12, made there unless it is there (scripts/fresh_machine.sh); a copy of it is used
--kept FOLDER      the machine itself, which stays: pages are tried on it one by one, after one ./firn demo. It shows no more
                   what a command installs that an earlier one installed
--at FOLDER        of the clone in the machine: this clone's own folder, and its compiler cache serves without -g too
--cold             without this machine's compiler cache: what a new user waits for
--limit S          seconds for one command (default 1800)
--test             ./firn test too, at the end

Needs root, debootstrap, a network, and 12 GB in $TMPDIR or /var/tmp. The clone is of the last commit.
"""
import argparse
import csv
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from doc_commands import A_RUN, commands_of  # noqa: E402

FRESH = ROOT / "scripts" / "fresh_machine.sh"
HOME = "/root"  # of the machine
INSIDE = f"{HOME}/firn"  # unless --at; as .ci/run has it, so that the compiler's cache serves both
COLUMNS = ("page", "line", "command", "exit", "seconds", "cpu_s", "packages", "downloaded_MB", "build_MB", "machine_MB", "wrong")
ONCE = re.compile(r"\./firn (demo|compare|reproduce)\b(?!.*RUN)")  # the same on every page
SERVES = re.compile(r"\./firn view|python3 \S*fake_lab\.py")        # until somebody ends it
ADDRESS = re.compile(r"http://[\w.:]+/\S*")
MB = 1e6


def output(*words):
    return subprocess.run(words, capture_output=True, text=True, check=False).stdout


def packages():
    """@returns {name: bytes to download} of what is installed, and of the packages that ./firn unpacks for their headers."""
    names = output("dpkg-query", "-W", "-f=${db:Status-Status} ${Package}\n").splitlines()
    unpacked = [folder.name for folder in Path("/root/.cache/firn/headers").glob("*/*") if folder.is_dir()]
    return {line.split()[1] for line in names if line.startswith("installed ")} | set(unpacked)


def to_download(names):
    """@returns bytes, by apt's own figures."""
    shown = output("apt-cache", "show", "--no-all-versions", *sorted(names)) if names else ""
    return sum(int(size) for size in re.findall(r"^Size: (\d+)$", shown, re.M))


def cpu_s():
    """@returns processor time of all commands that have ended [s]"""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def folder_mb(folder):
    words = output("du", "-sxm", "--exclude=/var/cache/ccache", str(folder)).split()
    return int(words[0]) if words else 0


def newest_run(place):
    return (made_runs(place) or [""])[-1]


def made_runs(place):
    """@returns the runs that were printed here, the newest last."""
    runs = [folder for folder in (place / "runs").glob("*-*") if folder.is_dir()]
    return [f"runs/{run.name}" for run in sorted(runs, key=lambda run: run.stat().st_mtime)]


def with_runs(line, place):
    """RUN is the newest run; of two, the one before it and the newest."""
    runs = made_runs(place)[-len(re.findall(r"\bRUN\b", line)) or None:]
    return re.sub(r"\bRUN\b", lambda _: runs.pop(0) if len(runs) > 1 else (runs or [""])[0], line)


class Reader:
    """Gives commands in a clone, and keeps what each cost."""

    def __init__(self, place, limit_s, rows):
        self.place, self.limit_s, self.rows, self.given, self.serving = Path(place), limit_s, rows, set(), []

    def shell(self, line):
        """@returns exit code (None: not within the limit), what it said, seconds"""
        began = time.monotonic()
        process = subprocess.Popen(["bash", "-c", line], cwd=self.place, text=True, errors="replace", stdin=subprocess.DEVNULL,
                                   stdout=self.log, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            code = process.wait(self.limit_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            code = process.wait() and None
        return code, time.monotonic() - began

    def serve(self, line):
        """A command that goes on: @returns 0 if its page can be fetched, or if it still runs after 3 s."""
        began = time.monotonic()
        process = subprocess.Popen(["bash", "-c", "exec " + line], cwd=self.place, stdin=subprocess.DEVNULL, stdout=self.log,
                                   stderr=subprocess.STDOUT, start_new_session=True)
        self.serving.append(process)
        code = None
        while code is None and process.poll() is None and time.monotonic() - began < self.limit_s:
            time.sleep(0.5)
            address = ADDRESS.search(self.said())
            if address:
                code = 0 if urllib.request.urlopen(address.group(0), timeout=30).status == 200 else 1
            elif "view" not in line and time.monotonic() - began > 3:
                code = 0
        if "view" in line and process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(30)
        return process.returncode if code is None else code, time.monotonic() - began

    def said(self):
        return Path(self.log.name).read_text(encoding="utf-8", errors="replace")

    def run(self, page, number, line, exits, given=""):
        line = with_runs(line, self.place)
        before, used_s = packages(), cpu_s()
        with tempfile.NamedTemporaryFile("w", suffix=".log") as self.log:
            code, took = self.serve(line) if SERVES.search(line) else self.shell(line)
            said = self.said()
        used_s = cpu_s() - used_s
        added = packages() - before
        wrong = "" if code in exits else f"not within {self.limit_s} s" if code is None else f"expected {' or '.join(map(str, exits))}"
        self.rows.writerow((page, number, line, code, f"{took:.1f}", f"{used_s:.1f}", " ".join(sorted(added)), f"{to_download(added) / MB:.0f}",
                            folder_mb(self.place / "build"), folder_mb("/") if added else "", wrong))
        sys.stdout.flush()
        if wrong:
            print(f"try_docs: {page}:{number}: {line}\n{said[-3000:]}", file=sys.stderr, flush=True)
        return not wrong

    def page(self, page, commands):
        """@returns the number of commands that failed. The clone is as it was afterwards."""
        wrong = 0
        for one in commands:
            if one.left_out or (ONCE.match(one.shell) and one.shell in self.given):
                continue
            self.given.add(one.shell)
            if one.text:
                (self.place / one.given).write_text(one.text, encoding="utf-8")
                continue
            for line in one.before:
                wrong += not self.run(page, one.line, line, (0, 4))
            if one.wants_run and not newest_run(self.place):
                wrong += not self.run(page, one.line, A_RUN, (0, 4))
            wrong += not self.run(page, one.line, one.shell, one.exits)
        self.leave()
        return wrong

    def leave(self):
        """Ends what the page left running, in this machine of its own, and takes its files away."""
        mine = {1, os.getpid(), os.getppid()}
        for process in Path("/proc").glob("[0-9]*"):
            if int(process.name) not in mine:
                os.kill(int(process.name), signal.SIGKILL)
        self.serving = []
        subprocess.run("git checkout -q . && git clean -fdq && rm -rf runs/*-* ~/.config/firn", shell=True, cwd=self.place, check=True)


def inside(arguments):
    """On the fresh machine, where ./firn demo has run."""
    rows = csv.writer(sys.stdout)
    reader = Reader(arguments.at, arguments.limit, rows)
    reader.given.add("./firn demo")
    pages = commands_of(Path(arguments.at), arguments.pages)
    wrong = sum(reader.page(page, commands) for page, commands in pages.items())
    if arguments.test:
        wrong += not reader.run("README.md", 0, "FIRN_ALLOW_SKIP=network-namespace ./firn test", (0,))
    return 1 if wrong else 0


def compiler_cache():
    folder = Path(output("ccache", "-k", "cache_dir").strip() or Path.home() / ".cache" / "ccache") if shutil.which("ccache") else None
    return ["--bind", str(folder), "/var/cache/ccache"] if folder and folder.is_dir() else []


def within(machine, folder):
    """@returns a machine's folder as this one sees it."""
    return machine / folder.lstrip("/")


def first_row(machine, at, binds, environment):
    """./firn demo as the machine's first command; python, which counts, comes with it."""
    size = folder_mb(machine)
    listed = ["dpkg-query", "--root", str(machine), "-W", "-f=${Package}\n"]
    before, used_s, began = set(output(*listed).split()), cpu_s(), time.monotonic()
    with tempfile.TemporaryFile("w+") as log:
        status = subprocess.run([FRESH, "run", machine, *binds, "--", f"{at}/firn", "demo"], env=environment, stdout=log, stderr=log,
                                check=False).returncode
        log.seek(0)
        said = log.read()
    took, used_s = time.monotonic() - began, cpu_s() - used_s
    added = set(output(*listed).split()) - before
    unpacked = [folder.name for folder in Path(machine, "root/.cache/firn/headers").glob("*/*") if folder.is_dir()]
    bytes_ = sum(int(n) for n in re.findall(r"^Size: (\d+)$", subprocess.run(
        [FRESH, "run", machine, "--", "apt-cache", "show", "--no-all-versions", *sorted(added), *unpacked],
        capture_output=True, text=True, check=False).stdout, re.M))
    lists_mb = folder_mb(Path(machine, "var/lib/apt/lists"))
    csv.writer(sys.stdout).writerow(("README.md", 0, "./firn demo", status, f"{took:.1f}", f"{used_s:.1f}", " ".join(sorted(added)), f"{bytes_ / MB:.0f}",
                                     folder_mb(within(machine, at) / "build"), folder_mb(machine),
                                     "" if status in (0, 4) else "the first command failed"))
    print(f"try_docs: before it the machine had {size} MB; apt's lists are {lists_mb} MB", file=sys.stderr, flush=True)
    if status not in (0, 4):
        print(said[-4000:], file=sys.stderr)
    return (within(machine, at) / "build/bin/firn-demo").is_file()  # a busy computer may stop a print: the rest can be tried


def take_machine(machine, empty):
    """@returns 0, or the exit code where no fresh machine can be had."""
    if not empty:
        empty = Path(tempfile.mkdtemp(prefix="firn-empty.", dir=os.environ.get("TMPDIR", "/var/tmp"))) / "debian"
    if not empty.is_dir() and (made := subprocess.run([FRESH, "make", empty], check=False).returncode):
        return made
    machine.mkdir(parents=True, exist_ok=True)
    subprocess.run(["cp", "-a", f"{empty}/.", machine], check=True)
    machine.chmod(0o755)
    return 0


def outside(arguments):
    machine = arguments.kept or Path(tempfile.mkdtemp(prefix="firn-docs.", dir=os.environ.get("TMPDIR", "/var/tmp")))
    clone = within(machine, arguments.at)
    known = clone.is_dir()
    try:
        if known:
            subprocess.run(["git", "-C", clone, "fetch", "-q", ROOT, "HEAD"], check=True)
            subprocess.run(["git", "-C", clone, "reset", "-q", "--hard", "FETCH_HEAD"], check=True)
        else:
            if refused := take_machine(machine, arguments.machine):
                return refused
            subprocess.run(["git", "clone", "-q", "--no-local", ROOT, clone], check=True)
        environment, binds = dict(os.environ), [] if arguments.cold else compiler_cache()
        if binds:
            environment["CCACHE_DIR"] = "/var/cache/ccache"
        csv.writer(sys.stdout).writerow(COLUMNS)
        if not known and not first_row(machine, arguments.at, binds, environment):
            return 1
        return subprocess.run([FRESH, "run", machine, *binds, "--", "python3", "-B", f"{arguments.at}/scripts/try_docs.py", "--inside",
                               "--at", arguments.at, "--limit", str(arguments.limit), *(["--test"] if arguments.test else []), *arguments.pages],
                              env=environment, check=False).returncode
    finally:
        if not arguments.kept:
            shutil.rmtree(machine, ignore_errors=True)


def list_commands(pages):
    for page, commands in commands_of(ROOT, pages).items():
        for one in commands:
            print(json.dumps({"page": page, "line": one.line, "command": one.shell or f"(writes {one.given})", "exits": one.exits,
                              "before": one.before, "left out": one.left_out}, ensure_ascii=False))
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="*", metavar="PAGE")
    parser.add_argument("--machine", type=Path)
    parser.add_argument("--kept", type=Path)
    parser.add_argument("--at", default=INSIDE)
    parser.add_argument("--cold", action="store_true")
    parser.add_argument("--limit", type=float, default=1800)
    parser.add_argument("--test", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    return list_commands(arguments.pages) if arguments.list else inside(arguments) if arguments.inside else outside(arguments)


if __name__ == "__main__":
    sys.exit(main())
