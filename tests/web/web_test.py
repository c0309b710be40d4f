#!/usr/bin/env python3
"""Runs the page's own tests with node: `web_test.py SOURCES data|browser|live [FIRN]`; `install` only fetches the packages.

The packages of web/package-lock.json are installed into web/node_modules first, once for each lockfile. A machine without
node, npm, chromium or npm's registry skips (exit code 77), which scripts/run_tests.py counts as a failure unless
FIRN_ALLOW_SKIP names it.
"""
import fcntl
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

SKIPPED = 77  # tests/support/skip.h
TESTS = {"data": ["test/data.test.mjs", "test/bundle.test.mjs"], "browser": ["test/watch.test.mjs", "test/over.test.mjs", "test/beside.test.mjs"],
         "live": ["test/live.test.mjs"]}
NEEDS = {"data": ["node"], "browser": ["node", "chromium"], "live": ["node", "chromium", "script"], "install": ["node"]}
INSTALL = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--prefer-offline"]


def skip(what, why):
    print(f"skipped: {what}: {why}")
    sys.exit(SKIPPED)


def install(web):
    """npm ci, unless node_modules is what this lockfile made; one at a time."""
    wanted = hashlib.sha256((web / "package-lock.json").read_bytes()).hexdigest()
    with open(web / ".npm-lock", "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        made = web / "node_modules" / ".firn-lockfile"
        if made.is_file() and made.read_text(encoding="ascii") == wanted:
            return
        if not shutil.which("npm"):
            skip("npm", "there is no npm to install the packages of web/package-lock.json")
        done = subprocess.run(INSTALL, cwd=web, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=240)
        if done.returncode:
            skip("npm", "npm ci failed: " + " ".join(done.stdout.split())[-400:])
        made.write_text(wanted, encoding="ascii")


def main():
    web, what = Path(sys.argv[1]) / "web", sys.argv[2]
    for program in NEEDS[what]:
        if not shutil.which(program):
            skip(program, f"there is no {program} on this machine")
    install(web)
    if what not in TESTS:
        return
    environment = {**os.environ, "FIRN_CHROMIUM": shutil.which("chromium") or "",
                   "FIRN_BINARY": sys.argv[3] if len(sys.argv) > 3 else "", "FIRN_SOURCES": str(web.parent)}
    sys.exit(subprocess.run(["node", "--test", *TESTS[what]], cwd=web, env=environment).returncode)


if __name__ == "__main__":
    main()
