#!/usr/bin/env python3
"""Instruments that a class in Python drives: experiments/drivers/scpi_lamp.py on the supply of tests/examples/fake_psu.py, with
its faults; classes that hang, die and use their own library; a live print, its record and its replay.

    tests/live/python_driver_test.py ROOT BUILD
"""
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from late_stops import finished  # noqa: E402

PATIENCE_S = 300
ROOT = BUILD = None

# Each is a lamp class that goes wrong in `on`.
BROKEN = {
    "Hangs": "        time.sleep(3600)",
    "Spins": "        while True: pass",
    "Raises": "        raise ValueError('no lamp at all')",
    "Dies": "        os.kill(os.getpid(), signal.SIGKILL)",
    "Exits": "        os._exit(3)",
    "Crashes": "        ctypes.string_at(0)",
    "HoldsTheInterpreter": "        ctypes.PyDLL(None).sleep(3600)",
    "Deaf": "        self.port.ask('NOTHING?')",
}
BROKEN_FILE = """import ctypes
import os
import signal
import time

from scpi_lamp import Lamp

""" + "\n\n".join(f"class {name}(Lamp):\n    def on(self, iris_percent=100):\n        super().on(iris_percent)\n{body}\n"
                  for name, body in BROKEN.items())
OWN_FILE = """import socket

from firn import Refused


class Lamp:
    \"\"\"Opens its instrument itself, as a class on a maker's library does.\"\"\"

    def __init__(self, host, port):
        self.line = socket.create_connection((host, port), timeout=1).makefile("rw")

    def ask(self, text):
        print(text, file=self.line, flush=True)
        return self.line.readline().strip()

    def identify(self):
        return self.ask("*IDN?")

    def on(self, iris_percent=100):
        print("CURR 0.5;OUTP ON", file=self.line, flush=True)

    def off(self):
        print("OUTP OFF", file=self.line, flush=True)

    def safe(self):
        self.off()
        if self.ask("OUTP?") != "0":
            raise RuntimeError("the output is still on")
"""


class Supply:
    """tests/examples/fake_psu.py beside a test."""

    def __init__(self, folder):
        self.log = Path(folder) / "psu.log"
        self.process = subprocess.Popen([sys.executable, "-B", f"{ROOT}/tests/examples/fake_psu.py", "--log", self.log],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        self.number = int(self.address.rpartition(":")[2])

    def hurt(self, kind):
        """Returns when it is so."""
        self.process.stdin.write(kind + "\n")
        self.process.stdin.flush()
        told = self.process.stderr.readline().strip()
        if told != f"psu: {kind}":
            raise RuntimeError(told)

    def changes(self):
        """"on", "off" in the order in which they came."""
        return [line.split()[1] for line in self.log.read_text().splitlines()]

    def wait_for(self, last):
        for _ in range(1000):
            if self.changes()[-1:] == [last]:
                return
            time.sleep(0.01)
        raise RuntimeError(f"the output did not go {last}: {self.changes()}")

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


class PythonDriverTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.place = Path(scratch.name)
        shutil.copy(f"{ROOT}/experiments/drivers/scpi_lamp.py", self.place)
        (self.place / "broken.py").write_text(BROKEN_FILE)
        (self.place / "own.py").write_text(OWN_FILE)
        text = Path(f"{ROOT}/experiments/drivers/scpi-lamp.toml").read_text()
        (self.place / "lab.toml").write_text(text.replace("../../labs", f"{ROOT}/labs"))
        self.psu = Supply(self.place)
        self.addCleanup(self.psu.end)

    def lamp(self, kind="scpi_lamp.py:Lamp", port=None):
        return ["--set", f'devices.lamp.port="{port or self.psu.address}"', "--set", f'devices.lamp.kind="python:{kind}"']

    def firn(self, *words):
        said = subprocess.run([Path(BUILD) / "bin" / "firn", *map(str, words)], cwd=self.place, capture_output=True, text=True,
                              timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
        text = said.stdout + said.stderr
        if said.returncode != 0 and "multicast" in text:
            print(f"skipped: multicast: {text.strip().splitlines()[-1]}")
            self.skipTest("multicast")
        return said.returncode, text

    def device(self, *words, **lamp):
        return self.firn("device", "lab.toml", "lamp", *words, *self.lamp(**lamp))

    def print_part(self, *words, **lamp):
        # The profiler keeps its rows, however busy this machine is.
        code, text = self.firn("print", "lab.toml", "--accept-bringup", "all", "--set", 'laser_profiler.read="memory"',
                               *self.lamp(**lamp), *words)
        run = re.search(r"run folder ([^\s,]+)", text)
        run = self.place / run.group(1) if run else None
        return *finished(self.firn, code, text, run), run

    # --- One instrument alone.
    def test_a_scpi_lamp_names_itself_and_shines_for_its_time(self):
        code, text = self.device("identify")
        self.assertEqual(code, 0, text)
        self.assertIn("FIRN,FAKE PSU,0042,1.0", text)
        code, text = self.device("expose", "0.3", "80")
        self.assertEqual(code, 0, text)
        self.assertEqual(self.psu.changes(), ["on", "off"])
        on, off = (float(line.split()[0]) for line in self.psu.log.read_text().splitlines())
        self.assertGreaterEqual(off - on, 0.3)
        self.assertIn("0.5600 A", self.psu.log.read_text())

    def test_answers_that_come_a_byte_at_a_time_or_late_are_understood(self):
        for kind in ("split", "late 0.05"):
            self.psu.hurt(kind)
            code, text = self.device("expose", "0.2", "80")
            self.assertEqual(code, 0, f"{kind}: {text}")

    def test_each_fault_of_the_supply_is_named_and_leaves_its_output_off(self):
        for kind, words in (("silent", "TimeoutError: no line within 0.3 s"), ("nonsense", "RuntimeError"), ("refuse", "Settings conflict")):
            self.psu.hurt(kind)
            code, text = self.device("identify", "--within", "3")
            self.assertNotEqual(code, 0, f"{kind}: {text}")
            self.assertIn(words, text)
            self.psu.hurt("ok")
        for kind, words in (("dark", "it was switched on, and does not shine"), ("door", "the door of the lamp's housing is open")):
            self.psu.hurt(kind)
            code, text = self.device("expose", "0.2", "80")
            self.assertEqual(code, 1, f"{kind}: {text}")
            self.assertIn(words, text)
            self.assertIn(self.psu.changes()[-1:], (["off"], []))
            self.psu.hurt("ok")

    def test_an_output_that_does_not_go_off_is_never_called_safe(self):
        process = subprocess.Popen([f"{BUILD}/bin/firn", "device", "lab.toml", "lamp", "expose", "0.3", "80", *self.lamp(), "--within", "5"],
                                   cwd=self.place, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.psu.wait_for("on")
        self.psu.hurt("stuck")
        text, _ = process.communicate(timeout=PATIENCE_S)
        self.assertNotEqual(process.returncode, 0, text)
        self.assertIn("switched off, and shines", text)
        self.assertIn("it may not be safe", text)

    def test_ctrl_c_in_an_exposure_switches_the_output_off(self):
        process = subprocess.Popen([f"{BUILD}/bin/firn", "device", "lab.toml", "lamp", "expose", "20", "80", *self.lamp()],
                                   cwd=self.place, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.psu.wait_for("on")
        process.send_signal(signal.SIGINT)
        text, _ = process.communicate(timeout=PATIENCE_S)
        self.assertEqual(process.returncode, 130, text)
        self.assertEqual(self.psu.changes()[-1], "off")

    def test_a_class_that_hangs_raises_dies_or_crashes_is_named_and_its_output_goes_off(self):
        for name, told in (("Hangs", "has not returned within 1"), ("Spins", "has not returned within 1"),
                           ("Raises", "broken.py, line "), ("Dies", "its program has ended"), ("Exits", "its program has ended"),
                           ("Crashes", "its program has ended"), ("HoldsTheInterpreter", "has not returned within 1"),
                           ("Deaf", "TimeoutError")):
            with self.subTest(name):
                code, text = self.device("expose", "5", "80", kind=f"broken.py:{name}")
                self.assertNotEqual(code, 0, text)
                self.assertIn(f"lamp: broken.py: {name}.on: ", text)
                self.assertIn(told, text)
                self.psu.wait_for("off")

    def test_no_program_of_a_class_outlives_firn(self):
        self.device("expose", "5", "80", kind="broken.py:Hangs")
        for _ in range(1000):
            alive = subprocess.run(["pgrep", "-f", f"broken.py={self.place}"], capture_output=True, text=True).stdout.split()
            if not alive:
                return
            time.sleep(0.01)
        self.fail(f"still there: {alive}")

    def test_a_file_that_is_no_class_is_refused_with_its_line(self):
        (self.place / "bad.py").write_text("class Lamp:\n    safe_bytes = b''\n    def on(self:\n")
        code, text = self.device("identify", kind="bad.py:Lamp")
        self.assertNotEqual(code, 0)
        self.assertIn("bad.py, line 3: SyntaxError", text)
        (self.place / "bad.py").write_text("class Lamp:\n    safe_bytes = b''\n    def identify(self): return 'x'\n")
        code, text = self.device("identify", kind="bad.py:Lamp")
        self.assertIn("class Lamp has no method on(), off(), safe()", text)
        code, text = self.device("identify", kind="none.py:Lamp")
        self.assertEqual(code, 2, text)
        self.assertIn("none.py", text)

    def test_a_cassette_plays_the_supply_to_the_class_again(self):
        code, text = self.device("expose", "0.2", "80", "--record", "lamp.cassette")
        self.assertEqual(code, 0, text)
        self.psu.end()
        code, text = self.firn("cassette", "lamp.cassette")
        self.assertEqual(code, 2, text)
        self.assertIn('devices.lamp.port = "cassette:FILE"', text)
        code, text = self.device("expose", "0.2", "80", port="cassette:lamp.cassette")
        self.assertEqual(code, 0, text)

    def test_a_class_with_its_own_library_is_driven_and_replayed_from_its_cassette_without_it(self):
        kind = f"own.py:Lamp(host='127.0.0.1', port={self.psu.number})"
        code, text = self.device("expose", "0.2", "80", "--record", "own.cassette", kind=kind, port="python:")
        self.assertEqual(code, 0, text)
        self.assertEqual(self.psu.changes(), ["on", "off"])
        self.psu.end()
        (self.place / "own.py").unlink()
        code, text = self.firn("cassette", "own.cassette")
        self.assertEqual(code, 0, text)

    def test_bring_up_asks_the_class_alone_and_sends_no_maker_s_frames(self):
        code, text = self.firn("bringup", "lab.toml", "--device", "lamp", "--json", "--answer", "59=yes", *self.lamp())
        rows = {row["row"]: row for row in json.loads(text)["rows"] if row["node"] == "lamp"}
        self.assertEqual({number: row["state"] for number, row in rows.items()}, {0: "ok", 59: "ok"}, text)
        self.assertIn("FIRN,FAKE PSU,0042,1.0", rows[0]["measured"])

    # --- A print.
    def test_a_print_records_class_and_calls_and_replays_without_python_and_instrument(self):
        code, text, run = self.print_part()
        self.assertEqual(code, 0, text)
        self.assertIn("REAL: lamp", text)
        provenance = (run / "provenance.json").read_text()
        self.assertIn("python-driver/lamp/scpi_lamp.py", provenance)
        layers = self.psu.changes()
        self.assertEqual(layers, ["on", "off"] * (len(layers) // 2))
        self.assertGreater(len(layers), 0)
        self.psu.end()
        (self.place / "scpi_lamp.py").write_text("raise SystemExit('a replay runs no class')\n")
        code, text = self.firn("replay", run)
        self.assertEqual(code, 0, text)
        self.assertIn("identical", text)
        self.assertEqual(self.firn("audit", run)[0], 0)

    def test_a_class_that_hangs_stops_the_print_by_name_and_its_output_is_off(self):
        code, text, run = self.print_part(kind="broken.py:Hangs")
        self.assertEqual(code, 3, text)
        self.assertIn("Hangs.on: it has not returned within 1", json.loads((run / "result.json").read_text())["reason"])
        self.psu.wait_for("off")
        self.assertEqual(self.firn("replay", run)[0], 0)

    def test_a_print_whose_lamp_node_was_killed_in_an_exposure_goes_on_and_replays(self):
        code, text, run = self.print_part("--detach")
        self.assertEqual(code, 0, text)
        self.psu.wait_for("on")
        nodes = subprocess.run(["pgrep", "-f", f"bin/lamp .*{run.name}"], capture_output=True, text=True).stdout.split()
        self.assertEqual(len(nodes), 1, nodes)
        os.kill(int(nodes[0]), signal.SIGKILL)
        code, text = self.firn("attach", run)
        self.assertEqual(code, 3, text)
        code, text = self.firn("print", "--resume", run)
        self.assertEqual(code, 0, text)
        self.psu.wait_for("off")
        for command in ("replay", "audit"):
            code, text = self.firn(command, run)
            self.assertEqual(code, 0, text)

    def test_a_driver_in_python_has_no_simulated_instrument(self):
        code, text = self.firn("print", "lab.toml", *self.lamp(port="sim:"))
        self.assertEqual(code, 2, text)
        self.assertIn("devices.lamp.port", text)
        code, text = self.firn("print", "lab.toml", "--bus", "in-process", *self.lamp())
        self.assertEqual(code, 2, text)


if __name__ == "__main__":
    ROOT, BUILD = (str(Path(word).resolve()) for word in sys.argv[1:3])
    result = unittest.main(argv=sys.argv[:1] + sys.argv[3:], exit=False).result
    sys.exit(77 if result.skipped else not result.wasSuccessful())
