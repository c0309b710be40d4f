#!/usr/bin/env python3
"""Programs of the lab's own in live prints: started, heard, recorded, replayed, refused, lost.

    tests/live/own_programs_test.py ROOT BUILD

All is in a network namespace of the test, whose multicast leads to lo, as docs/own-lcm-program.md asks of stock LCM.
"""
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from late_stops import finished  # noqa: E402

PATIENCE_S = 300
SPEEDUP = "4"
INSIDE = "FIRN_TEST_NAMESPACE"
ROOT = BUILD = None
PART = """include = "{root}/labs/inkjet-lu2015.toml"

[run]
name = "tiny"

[grid]
nx = 9
ny = 9

[part]
shape = "cuboid"
width_mm = 1.5
depth_mm = 1.5
height_mm = 0.03

[laser_profiler]
read = "memory"

[control]
scheme = "mpc"
{control}
{nodes}
"""
# A program that says a line of the test's and ends when the print does.
PROGRAM = """
import json, os, select, struct, sys, time
sys.path.insert(0, "{root}/experiments/own-lcm")
from own_bus import Bus
admission = json.loads(sys.stdin.readline())
bus = Bus(admission)
sys.stdin.readline()  # START
{act}
while sys.stdin.readline():
    pass
"""


class OwnProgramsTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.place = Path(scratch.name)

    def part(self, nodes="", control=""):
        (self.place / "part.toml").write_text(PART.format(root=ROOT, nodes=nodes, control=control))

    def program(self, act):
        (self.place / "own.py").write_text(PROGRAM.format(root=ROOT, act=textwrap.dedent(act)))
        return f"command = \"{sys.executable} {self.place}/own.py\""

    def asked(self, *words, text=None):
        said = subprocess.run([Path(BUILD) / "bin" / "firn", *map(str, words)], cwd=self.place, capture_output=True,
                              text=True, timeout=PATIENCE_S, input=text or "")
        return said.returncode, said.stdout + said.stderr

    def firn(self, *words, wanted=0, text=None):
        code, said = self.asked(*words, text=text)
        self.assertEqual(code, wanted, said)
        return said

    def print(self, wanted=0, *words):
        code, said = self.asked("print", "part.toml", "--runs", "runs", "--no-page", "--speedup", SPEEDUP, *words)
        if wanted == 0 and code != 0:
            code, said = finished(self.asked, code, said, next((self.place / "runs").iterdir(), None))
        self.assertEqual(code, wanted, said)
        return said

    def run_folder(self):
        return next((self.place / "runs").iterdir())

    def messages(self, channel):
        self.firn("runs", "expand", self.run_folder())
        text = self.firn("log", "cat", self.run_folder() / "log.lcm", "-c", channel, "--full")
        return [json.loads(line) for line in text.splitlines() if line.startswith("{")]

    def members(self, channel):
        return [m.get("message", m) for m in self.messages(channel)]

    def check_replays(self):
        self.assertIn("identical", self.firn("replay", self.run_folder()))
        self.firn("audit", self.run_folder())

    def test_an_estimator_that_the_print_starts_is_recorded_acted_on_and_replayed(self):
        self.part("[nodes.estimate]\ncommand = \"python3 {}/experiments/own-lcm/estimate.py\"".format(ROOT),
                  "adapt_model = \"own:estimate\"")
        self.print()
        told = self.members("OWN_HEIGHT_MODEL")
        self.assertTrue(told)
        self.assertEqual({m["program"] for m in told}, {"estimate"})
        self.assertIn("a droplet adds", (self.run_folder() / "nodes/estimate.err").read_text())
        self.check_replays()

    def test_rubbish_of_a_program_is_dropped_counted_and_told_and_the_print_is_as_without(self):
        act = """
            for n in range(40):
                bus.publish("OWN_VALUES", os.urandom(n * 37))
                bus.publish("JET_COMMAND", b"fire")
                bus.publish("OWN_HEIGHT_MODEL", struct.pack(">Q", n))
                time.sleep(0.02)"""
        self.part("[nodes.room]\n" + self.program(act))
        said = self.print()
        self.assertRegex(said, r"room: 0 messages taken, 120 refused \(the last: OWN_HEIGHT_MODEL: byte 0")
        self.assertEqual(self.messages("OWN_VALUES"), [])
        faults = [m["text"] for m in self.members("FAULT_LAUNCHER")]
        self.assertEqual(len([f for f in faults if f.startswith("room: a message was refused")]), 3)
        self.check_replays()

    def test_a_needed_program_that_ends_stops_the_print_by_its_last_words_and_a_resume_finishes_it(self):
        act = f"""
            if not os.path.exists("{self.place}/once"):
                open("{self.place}/once", "w").close()
                time.sleep(1.0)
                sys.exit("no thermometer at /dev/ttyUSB7")"""
        self.part("[nodes.room]\n" + self.program(act))
        said = self.print(3)
        self.assertRegex(said, r"room \(.*own.py\) exited with code 1: no thermometer at /dev/ttyUSB7")
        self.firn("print", "--resume", self.run_folder())
        self.check_replays()

    def test_a_program_that_is_not_needed_is_missed_and_the_print_goes_on(self):
        self.part("[nodes.room]\nneeded = \"off\"\n" + self.program("sys.exit(5)"))
        self.assertRegex(self.print(), r"room \(.*\) exited with code 5.*the print goes on without it")
        self.check_replays()

    def test_a_needed_program_that_is_silent_for_too_long_stops_the_print(self):
        self.part("[nodes.room]\nlongest_silence_s = 1\n" + self.program(""))
        self.assertIn("nodes.room.longest_silence_s", self.print(3))

    def test_a_command_that_cannot_be_started_is_named_before_the_first_droplet(self):
        self.part("[nodes.room]\ncommand = \"./no-such-program\"")
        said = self.print(3)
        self.assertIn("room (./no-such-program) exited with code 127", said)
        self.assertNotIn("layer 1", said)

    def test_a_program_ends_with_a_launcher_that_is_killed(self):
        self.part("[nodes.room]\n" + self.program("open('%s/pid', 'w').write(str(os.getpid()))" % self.place))
        launcher = subprocess.Popen([Path(BUILD) / "bin" / "firn", "print", "part.toml", "--runs", "runs", "--no-page"],
                                    cwd=self.place, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                    stderr=subprocess.DEVNULL)
        pid_file = self.place / "pid"
        self.wait_for(lambda: pid_file.exists() and pid_file.read_text())
        pid = int(pid_file.read_text())
        launcher.kill()
        launcher.wait()
        self.wait_for(lambda: not Path(f"/proc/{pid}").exists() or "Z" in Path(f"/proc/{pid}/stat").read_text().split()[2])

    def wait_for(self, condition):
        until = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertLess(time.monotonic(), until)
            time.sleep(0.05)

    def test_others_speak_with_a_key_or_by_firn_say_while_it_prints(self):
        self.part()
        self.print(0, "--detach")
        run = self.run_folder()
        self.firn("ctl", run, "pause")
        room = '{"name": "room", "unit": "degC", "sample_utime_us": 0, "values": [21.5, null]}\n'
        self.assertIn("2 messages taken", self.firn("say", run, "OWN_VALUES", "--as", "room", text=room + "\n" + room))
        refused = self.firn("say", run, "OWN_VALUES", "--as", "room", text=room + '{"nam": 1}\n', wanted=2)
        self.assertRegex(refused, r"line 2: .*nam: own_values_t has no such member.*\(1 taken before\)")
        self.assertIn("is not for programs of the lab's own", self.firn("say", run, "JET_COMMAND", text="{}", wanted=2))
        self.assertIn("no name for a program", self.firn("key", run, "--as", "jet", wanted=2))
        admission = self.firn("key", run, "--as", "barometer", "--json")
        self.assertRegex(json.loads(admission)["key"], "^[0-9a-f]{64}$")
        values = subprocess.run([Path(BUILD) / "tests" / "own_values_example", "2"], input=admission, text=True,
                                capture_output=True, timeout=PATIENCE_S)
        self.assertEqual(values.returncode, 0, values.stderr)
        self.firn("ctl", run, "continue")
        self.firn("attach", run)
        told = self.members("OWN_VALUES")
        self.assertEqual([m["program"] for m in told], ["room"] * 3 + ["barometer"] * 2)
        self.assertEqual(told[0]["values"], [21.5, None])
        self.assertAlmostEqual(told[4]["values"][0], 1013.45)
        self.check_replays()
        self.assertIn("is not running", self.firn("say", run, "OWN_VALUES", text=room, wanted=2))

    def test_a_resume_of_a_strangers_run_asks_before_it_starts_a_command(self):
        self.part("[nodes.room]\n" + self.program("sys.exit(1)"))
        self.print(3)
        file = self.run_folder() / "provenance.json"
        file.write_text(re.sub(r'("origin": ")[0-9a-f]{8}', r"\g<1>00000000", file.read_text()))
        said = self.firn("print", "--resume", self.run_folder(), wanted=2)
        self.assertRegex(said, r"has commands or hosts \(nodes\.room\.command = .*--run-python runs it")

    def test_a_print_in_one_process_refuses_a_program_and_its_estimates(self):
        self.part("[nodes.room]\n" + self.program(""))
        self.assertIn("nodes.room.command: --bus in-process has no bus",
                      self.firn("print", "part.toml", "--bus", "in-process", wanted=2))
        self.part("", "adapt_model = \"own:room\"")
        self.assertIn("control.adapt_model = \"own:room\"",
                      self.firn("print", "part.toml", "--bus", "in-process", wanted=2))


def enter_namespace():
    """Starts this program again in a network namespace of its own; returns why it cannot."""
    if os.environ.get(INSIDE):
        for words in (("link", "set", "lo", "up"), ("link", "set", "lo", "multicast", "on"),
                      ("route", "add", "224.0.0.0/4", "dev", "lo")):
            subprocess.run(["ip", *words], check=True)
        return None
    if not shutil.which("ip"):
        return "the command ip is not installed"
    tried = subprocess.run(["unshare", "--net", "true"], capture_output=True, text=True)
    if tried.returncode:
        return tried.stderr.strip()
    os.environ[INSIDE] = "1"
    os.execvp("unshare", ["unshare", "--net", sys.executable, "-B", *sys.argv])


if __name__ == "__main__":
    ROOT, BUILD = sys.argv[1:3]
    why = enter_namespace()
    if why:
        print(f"skipped: network-namespace: {why}")
        sys.exit(77)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
