#!/usr/bin/env python3
"""The packages as their user meets them: on an empty Debian 12 without a compiler.

    tests/release/fresh_packages_test.py BUILD ROOT [--keep FOLDER]

Installs firn and prints the demo; gives every command of the tutorials; builds a program on firn-dev; removes all of it and looks
for what is left. Then carries out the Containerfile there, line by line, as a builder of containers would. Needs root, debootstrap and a package source (scripts/fresh_machine.sh); without them it is skipped. It says how
long each step took and gates nothing on it. --keep: the machine stays in FOLDER, for a look.
"""
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BUILD, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
MACHINE = ROOT / "scripts/fresh_machine.sh"
NO_MACHINE = 3
MOST_BYTES = 25e6
USER = "reader"
# Of apt and dpkg themselves, of caches, logs and accounts: whatever package is installed, they change these.
ITS_OWN = ("/var/lib/dpkg", "/var/lib/apt", "/var/cache", "/var/log", "/var/lib/systemd", "/etc/ld.so.cache", "/tmp", "/root", "/var/tmp", "/dev",
           "/proc", "/sys", "/packages", "/tests", f"/home/{USER}", "/run", "/etc/.pwd.lock", "/var/lib/ucf")
TUTORIALS = ("docs/tutorials/operator.md", "docs/tutorials/your-lab.md", "docs/exit-codes.md")
LIBRARY_USER = """
cmake -S /tests/examples/own_scheme -B /var/tmp/own -G 'Unix Makefiles' >/dev/null && cmake --build /var/tmp/own >/dev/null && /var/tmp/own/own_scheme
"""


def say(text):
    print(text, file=sys.stderr, flush=True)


class Fresh:
    def __init__(self, folder, packages):
        self.folder, self.packages = folder, packages
        made = subprocess.run([MACHINE, "make", folder], stdout=sys.stderr, check=False)
        if made.returncode == NO_MACHINE:
            print("skipped: fresh-machine: none can be had here")
            sys.exit(77)
        made.check_returncode()

    def sh(self, what, text, user=None, codes=(0,)):
        """Standard output of a shell's text on the machine, as root or as the user in his own folder."""
        began = time.monotonic()
        words = ["sh", "-ec", text] if user is None else ["su", "-", user, "-c", text]
        done = subprocess.run([MACHINE, "run", self.folder, "--bind", self.packages, "/packages", "--bind", ROOT / "tests", "/tests", "--",
                               *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        say(f"{what}: {time.monotonic() - began:.0f} s")
        if done.returncode not in codes:
            sys.exit(f"{what}: exit code {done.returncode}\n{done.stdout[-6000:]}")
        return done.stdout

    def files(self):
        return {line for line in self.sh("a look at all files", "find / -xdev").splitlines()
                if not any(line == own or line.startswith(own + "/") for own in ITS_OWN)}

    def install(self, *names):
        return "apt-get install -qq -y --no-install-recommends " + " ".join(names) + " >/dev/null 2>&1"


def main():
    keep = sys.argv[sys.argv.index("--keep") + 1] if "--keep" in sys.argv else None
    scratch = tempfile.mkdtemp()
    os.chmod(scratch, 0o755)
    packages = Path(scratch) / "packages"
    machine = Path(keep or Path(scratch) / "machine")
    try:
        files = subprocess.run([ROOT / "scripts/make_package.sh", BUILD, packages], check=True, stdout=subprocess.PIPE, text=True).stdout.split()
        here = {Path(file).name.split("_")[0]: f"/packages/{Path(file).name}" for file in files}
        size = (packages / Path(here["firn"]).name).stat().st_size
        say(f"package firn: {size:,} bytes")
        assert size <= MOST_BYTES, size
        visit(Fresh(machine, packages), here)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def visit(fresh, here):
    fresh.sh("apt-get update", "apt-get -qq update >/dev/null 2>&1")
    fresh.sh("an account", f"useradd --create-home --shell /bin/bash {USER}")
    before = fresh.files()

    began = time.monotonic()
    fresh.sh("apt install ./firn_*.deb", fresh.install(here["firn"]))
    told = json.loads(fresh.sh("firn demo", "firn demo --json 2>demo.log", USER))
    say(f"from apt install to the end of the demo: {time.monotonic() - began:.0f} s")
    assert all(run["identical"] for run in told["runs"]) and len(told["runs"]) >= 3, told
    fresh.sh("there is no compiler", "! command -v cc && ! command -v g++ && ! command -v clang && ! command -v python3")

    for command, wanted in (("firn --version", "firn 1."), ("firn", "firn demo"), ("firn help print", "firn print"),
                            ("firn reproduce thompson", "thompson.corners.fig7-speed"), ("firn config user", "/.config/firn/config.toml")):
        assert wanted in fresh.sh(command, command, USER), command
    fresh.sh("the copy that README.Debian names", "mkdir lab && cd lab && cp -r /usr/share/firn/. .", USER)
    fresh.sh("a print in the copy", "cd lab && firn print experiments/cuboid.toml --bus in-process --set part.height_mm=0.02", USER)

    fresh.sh("apt install ./python3-firn_*.deb", fresh.install(here["python3-firn"]))
    module = "import firn; r = firn.simulate('lab/experiments/cuboid.toml', settings={'part.height_mm': 0.02}); print(r.summary['outcome'])"
    assert fresh.sh("the module firn", f'python3 -c "{module}"', USER).strip() == "finished"
    for page in TUTORIALS:
        fake = " --with-fake-lab" if page.endswith("your-lab.md") else ""
        said = fresh.sh(f"every command of {page}", f"python3 -B /tests/docs/tutorials_test.py /usr/share/firn /usr/lib/firn {page}{fake}", USER,
                        codes=(0, 77))
        if "skipped" in said:
            say(said.strip())

    fresh.sh("a compiler, cmake, apt install ./firn-dev_*.deb", fresh.install("g++", "cmake", "make", here["firn-dev"]))
    told = json.loads(fresh.sh("a program on find_package(Firn)", LIBRARY_USER))
    assert told["fill_um"] < 0.5 * told["open_loop_um"], told

    fresh.sh("all of it removed", "apt-get purge -qq -y firn firn-dev python3-firn g++ cmake make >/dev/null 2>&1; "
                                  "apt-get autoremove --purge -qq -y >/dev/null 2>&1")
    left = sorted(fresh.files() - before)
    assert not [f for f in left if "firn" in f.lower()], left
    say(f"files of other packages that stay: {len(left)}")
    runs = fresh.sh("the runs are there", "ls -d runs/* lab/runs/*", USER).split()
    assert len(runs) >= 4, runs
    container(fresh, here)


def instructions(text):
    """(word, rest) of each instruction of a Containerfile; continued lines are one."""
    text = re.sub(r"^#.*\n", "", text, flags=re.M).replace("\\\n", " ")
    return [tuple(line.split(None, 1)) for line in text.splitlines() if line.strip()]


def container(fresh, here):
    """The lines of the Containerfile on the machine: it stands for the image that they begin with."""
    user, folder, environment, words = "root", "/", "", {}
    for word, rest in instructions((ROOT / "Containerfile").read_text()):
        if word == "FROM":
            assert rest == "docker.io/library/debian:${DEBIAN}-slim", rest
        elif word == "COPY":
            *names, to = rest.split()
            fresh.sh(rest, f"mkdir -p {to} && " + " && ".join(f"cp /packages/{name} {to}" for name in names))
        elif word == "RUN":
            assert user == "root"
            fresh.sh(f"RUN {rest[:50]}", f"({rest}) >/dev/null 2>&1")
        elif word == "USER":
            user = rest
        elif word == "WORKDIR":
            folder = rest
        elif word == "ENV":
            environment = f"export {rest}"
        elif word in ("ENTRYPOINT", "CMD"):
            words[word] = json.loads(rest)
        else:
            assert word in ("ARG", "EXPOSE"), word

    def inside(*more):
        return fresh.sh(" ".join(more), f"cd {folder} && {environment} && {shlex.join([*words['ENTRYPOINT'], *more])} 2>/dev/null", user)
    told = json.loads(inside(*words["CMD"], "--json"))
    assert all(run["identical"] for run in told["runs"]), told
    inside("print", "experiments/cuboid.toml", "--bus", "in-process", "--set", "part.height_mm=0.02")
    assert "cuboid" in inside("runs")


if __name__ == "__main__":
    main()
