#!/usr/bin/env python3
""".ci/run on a small tree of its own, with stand-ins for what it calls: the machine is a folder."""
import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STAND_INS = {
    "firn": 'echo "$PWD: firn $*"; [ "$1" != test ] || exec sh -c "$FIRN_TEST"',
    "scripts/fuzz.sh": 'echo "fuzz $*"',
    "scripts/sanitized_tests.sh": 'echo sanitized',
    "scripts/check_names.py": 'echo "names $*"',
    "scripts/check_includes.py": 'echo "includes $*"',
    "scripts/fresh_machine.sh": 'case $1 in\n'
                                'make) [ -z "$NO_MACHINE" ] || exit 3; mkdir -p "$2/root" ;;\n'
                                'run) machine=$2; while [ "$1" != -- ]; do shift; done; exec "$machine$2" "$3" ;;\nesac',
    "debootstrap": ":",
}


class ContinuousIntegration(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.tree, self.machines = Path(self.folder.name, "tree"), Path(self.folder.name, "machines")
        self.machines.mkdir()
        for name, text in STAND_INS.items():
            file = self.tree / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(f"#!/bin/sh\n{text}\n")
            file.chmod(0o755)
        (self.tree / ".ci").mkdir()
        shutil.copy(ROOT / ".ci/run", self.tree / ".ci/run")
        for words in (["init", "-q"], ["add", "-A"],
                      ["-c", "user.name=somebody", "-c", "user.email=somebody@localhost", "commit", "-q", "-m", "all"]):
            subprocess.run(["git", "-C", self.tree, *words], check=True)

    def tearDown(self):
        self.folder.cleanup()

    def start(self, **environment):
        return subprocess.Popen(["bash", ".ci/run"], cwd=self.tree, text=True, stdin=None, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                env={**os.environ, "TMPDIR": str(self.machines), "FIRN_TEST": "true", "NO_MACHINE": "",
                                     "PATH": f"{self.tree}:{os.environ['PATH']}", **environment})

    def run_ci(self, **environment):
        """@returns its status, what it said"""
        process = self.start(**environment)
        said, _ = process.communicate(timeout=120)
        self.assertEqual(list(self.machines.iterdir()), [], said)
        return process.returncode, said

    def test_the_two_commands_run_in_a_clone_on_the_machine_and_the_folder_is_removed(self):
        status, said = self.run_ci()
        self.assertEqual(status, 0, said)
        for command in ("firn demo", "firn test"):
            self.assertRegex(said, rf"{self.machines}/firn-fresh\.\w+/root" rf"/firn: {command}\n")
        self.assertIn("fuzz --each 30000", said)
        self.assertIn("\nsanitized\n", said)
        self.assertNotIn("NO FRESH MACHINE", said)

    def test_without_a_machine_it_runs_in_place_and_says_so(self):
        status, said = self.run_ci(NO_MACHINE="1")
        self.assertEqual(status, 0, said)
        self.assertIn("NO FRESH MACHINE CAN BE MADE HERE", said)
        self.assertIn(f"{self.tree}: firn test\n", said)

    def test_a_failure_is_its_own_and_ends_it(self):
        for environment in ({}, {"NO_MACHINE": "1"}):
            status, said = self.run_ci(FIRN_TEST="exit 8", **environment)
            self.assertEqual(status, 8, said)
            self.assertNotIn("fuzz", said)

    def test_changes_that_are_not_committed_are_left_out_and_told(self):
        (self.tree / "firn").write_text("#!/bin/sh\nexit 9\n")
        status, said = self.run_ci()
        self.assertEqual(status, 0, said)
        self.assertIn("UNCOMMITTED CHANGES ARE LEFT OUT", said)

    def test_a_signal_ends_what_runs_and_removes_the_folder(self):
        process = self.start(FIRN_TEST="touch $TMPDIR/../begun; sleep 60")
        while process.poll() is None and not Path(self.folder.name, "begun").exists():
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(timeout=30), 143)
        process.stdout.close()
        self.assertEqual(list(self.machines.iterdir()), [])


if __name__ == "__main__":
    unittest.main()
