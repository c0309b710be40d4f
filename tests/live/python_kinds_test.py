#!/usr/bin/env python3
"""Each class of instruments beside the lamp, driven by a small class in Python in its own program: stage, jet, profiler, camera,
point laser, gas, heater. It works; when it hangs, raises or dies in the middle that is a fault by name, and its instrument
is made safe.

    tests/live/python_kinds_test.py ROOT BUILD [short]    short: one way to fail for each class
"""
import json
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from late_stops import finished  # noqa: E402

PATIENCE_S = 300
ROOT = BUILD = None
SHORT = False

CLASSES = '''import os
import signal
import time


class Instrument:
    """Says each of its words on the port and awaits "ok"; fails as it was told, in its main method."""
    safe_bytes = "SAFE\\n"

    def __init__(self, port, how="well"):
        self.port, self.how = port, how

    def say(self, text):
        answer = self.port.ask(text)
        if answer != "ok":
            raise RuntimeError(answer)

    def identify(self):
        return self.port.ask("ID?")

    def safe(self):
        self.say("SAFE?")

    def work(self, text):
        self.say("WORK " + text)
        if self.how == "hangs":
            time.sleep(3600)
        if self.how == "raises":
            raise ValueError("nothing works")
        if self.how == "dies":
            os.kill(os.getpid(), signal.SIGKILL)


class Stage(Instrument):
    times_s = {"safe": 1.0}
    place = [0.0, 0.0, 5.0]

    def position(self):
        return self.place

    def home(self):
        self.say("HOME")

    def move(self, x_mm, y_mm, z_mm, speed_mm_s):
        self.work("move")
        self.place = [old if new != new else new for old, new in zip(self.place, (x_mm, y_mm, z_mm))]

    def fire(self, y_mm, start_x_mm, end_x_mm, speed_mm_s, at_mm):
        self.say("FIRE")
        self.place = [end_x_mm, y_mm, self.place[2]]
        return len(at_mm)

    def scan(self, x_mm, start_y_mm, end_y_mm, speed_mm_s, first_y_mm, pitch_mm, rows):
        self.say(f"SCAN {first_y_mm} {pitch_mm} {int(rows)}")
        self.place = [x_mm, end_y_mm, self.place[2]]
        return rows


class Jet(Instrument):
    def arm(self, expected):
        self.work(f"arm {int(expected)}")

    def disarm(self):
        self.say("DISARM")


class Profiler(Instrument):
    """Asks the stage's fake how its scan goes, as a profiler hears of it by its trigger line."""
    left = []

    def arm(self, rows):
        self.work(f"arm {int(rows)}")
        self.left = list(range(int(rows)))

    def rows(self):
        height, *scan = self.port.ask("ROWS?").split()
        if not self.left or not scan:
            return None
        first_y_mm, pitch_mm = map(float, scan)
        rows, self.left = self.left, []
        return {"row": rows, "y_mm": [first_y_mm + row * pitch_mm for row in rows], "x0_mm": -1.0, "dx_mm": 0.05,
                "z_mm": [[float(height)] * 120 for _ in rows]}

    def end(self):
        self.say("END")


class Lamp(Instrument):
    def on(self, iris_percent):
        self.work("on")

    def off(self):
        self.say("OFF")


class Camera(Instrument):
    def picture(self, delay_us, exposure_us, gain_db):
        self.work("picture")
        return [[10 * row + column for column in range(16)] for row in range(16)]


class Point(Instrument):
    def reading(self):
        self.work("reading")
        return 1.25


class Gas(Instrument):
    def set(self, atomizer_sccm, sheath_sccm):
        self.flow = [atomizer_sccm, sheath_sccm]
        if atomizer_sccm > 0:
            self.work("set")

    def read(self):
        return {"sccm": getattr(self, "flow", [0.0, 0.0]), "kpa": [101.0, 101.0]}


class Heater(Instrument):
    points = [20.0, 20.0, 20.0]

    def set(self, celsius):
        self.work("set")
        self.points = celsius

    def read(self):
        return {"celsius": [20.0, 20.0, 20.0], "heating": [0, 0, 0]}
'''

INKJET, AEROSOL, ICE = "inkjet-lu2015.toml", "aerosol-printer.toml", "ice-cobra600.toml"
# node: class, its main method, lab, order, nodes that are real together, further keys
KINDS = {
    "stage": ("Stage", "move", INKJET, ["move", "5", "5", "10", "20"], ["stage", "jet", "laser_profiler"], []),
    "laser_profiler": ("Profiler", "arm", INKJET, ["batch", "3", "2"], ["stage", "jet", "laser_profiler"], []),
    "camera": ("Camera", "picture", INKJET, ["read"], [], ['camera.use="on"']),
    "laser_point": ("Point", "reading", ICE, ["read"], ["robot", "valve_a", "valve_b", "laser_point"], []),
    "gas": ("Gas", "set", AEROSOL, ["set", "20", "40"], [], []),
    "heater": ("Heater", "set", ICE, ["set", "20", "5", "10"], [], []),
}
FAILS = {"hangs": "has not returned within", "raises": "ValueError: nothing works", "dies": "its program has ended"}


class Fake:
    """An instrument that keeps the lines that it hears, and answers them."""
    layers = 0  # heights that a profiler is told follow the lamp's exposures
    scan = ""

    def __init__(self, name):
        self.name, self.lines = name, []
        self.server = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp:127.0.0.1:{self.server.getsockname()[1]}"
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            try:
                line, _ = self.server.accept()
            except OSError:
                return
            threading.Thread(target=self.talk, args=(line,), daemon=True).start()

    def talk(self, line):
        with line, line.makefile("rwb") as both:
            try:
                for heard in both:
                    self.hear(heard.decode().strip(), both)
            except OSError:
                pass

    def was_made_safe(self):
        """By Firn's own bytes, after its last work. What was sent when firn ended may still be on its way."""
        for _ in range(1000):
            lines = list(self.lines)
            work = max(n for n, line in enumerate(lines) if line.startswith("WORK"))
            if "SAFE" in lines[work + 1:]:
                return True
            time.sleep(0.01)
        return False

    def hear(self, text, both):
        if text not in ("ROWS?", "ID?"):
            self.lines.append(text)
        if text.startswith("SCAN"):
            Fake.scan = " ".join(text.split()[1:3])
        if self.name == "lamp" and text == "OFF":
            Fake.layers += 1
        answer = {"ID?": f"FAKE {self.name} 1", "ROWS?": f"{0.0044 * Fake.layers:.4f} {Fake.scan or '0 0.25'}", "SAFE": None}
        said = answer.get(text, "ok")
        if said is not None:
            both.write(said.encode() + b"\n")
            both.flush()


class PythonKindsTest(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.place = Path(scratch.name)
        (self.place / "kinds.py").write_text(CLASSES)
        Fake.layers, Fake.scan = 0, ""

    def fake(self, name):
        fake = Fake(name)
        self.addCleanup(fake.server.close)
        return fake

    def firn(self, *words):
        said = subprocess.run([Path(BUILD) / "bin" / "firn", *map(str, words)], cwd=self.place, capture_output=True, text=True,
                              timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
        text = said.stdout + said.stderr
        if said.returncode != 0 and "multicast" in text:
            print(f"skipped: multicast: {text.strip().splitlines()[-1]}")
            self.skipTest("multicast")
        return said.returncode, text

    def order(self, node, how="well"):
        """Gives the instrument's order; returns code, text and the fake that heard it."""
        name, _, lab, words, coupled, keys = KINDS[node]
        # Relative: the class's file lies beside the experiment.
        (self.place / "lab.toml").write_text(f'include = "{ROOT}/labs/{lab}"\n')
        fake = self.fake(node)
        keys = [*keys, f'devices.{node}.port="{fake.address}"', f"devices.{node}.kind=\"python:kinds.py:{name}(how='{how}')\""]
        keys += [f'devices.{other}.port="tcp:127.0.0.1:9"' for other in coupled if other != node]
        code, text = self.firn("device", "lab.toml", node, *words, *(word for key in keys for word in ("--set", key)))
        return code, text, fake

    def ways(self, node):
        return list(FAILS)[list(KINDS).index(node) % len(FAILS):][:1] if SHORT else list(FAILS)

    def test_an_instrument_of_each_class_does_what_it_is_told(self):
        for node in KINDS:
            with self.subTest(node):
                code, text, fake = self.order(node)
                self.assertEqual(code, 0, text)
                self.assertTrue(any(line.startswith("WORK") for line in fake.lines), fake.lines)

    def test_a_class_that_hangs_raises_or_dies_is_a_fault_by_name_and_its_instrument_is_made_safe(self):
        for node, (name, method, *_) in KINDS.items():
            for how in self.ways(node):
                with self.subTest(node=node, how=how):
                    code, text, fake = self.order(node, how)
                    self.assertNotEqual(code, 0, text)
                    self.assertIn(f"{node}: kinds.py: {name}.{method}: ", text)
                    self.assertIn(FAILS[how], text)
                    self.assertTrue(fake.was_made_safe(), fake.lines)

    # --- A lab all of whose instruments are classes in Python.
    def print_part(self, how):
        (self.place / "lab.toml").write_text(f'include = "{ROOT}/experiments/drivers/scpi-lamp.toml"\n')
        fakes = {node: self.fake(node) for node in ("stage", "jet", "laser_profiler", "lamp")}
        names = {"stage": "Stage", "jet": f"Jet(how='{how}')", "laser_profiler": "Profiler", "lamp": "Lamp"}
        keys = ['control.scheme="open_loop"', "part.height_mm=0.0088", "laser_profiler.bias_limit_mm=0", "laser_profiler.offset_limit_mm=0",
                'laser_profiler.read="memory"']  # its class keeps its rows, however busy this machine is
        for node, fake in fakes.items():
            keys += [f'devices.{node}.port="{fake.address}"', f'devices.{node}.kind="python:kinds.py:{names[node]}"']
        code, text = self.firn("print", "lab.toml", "--accept-bringup", "all", *(word for key in keys for word in ("--set", key)))
        run = re.search(r"run folder ([^\s,]+)", text)
        run = self.place / run.group(1) if run else None
        code, text = finished(self.firn, code, text, run)
        return code, text, fakes, run

    def test_a_lab_of_classes_in_python_prints_and_replays_without_them(self):
        code, text, fakes, run = self.print_part("well")
        self.assertEqual(code, 0, text)
        self.assertIn("REAL: stage", text)
        self.assertTrue([line for line in fakes["stage"].lines if line == "FIRE"])
        self.assertTrue([line for line in fakes["jet"].lines if line.startswith("WORK arm")])
        (self.place / "kinds.py").write_text("raise SystemExit('a replay runs no class')\n")
        for command in ("replay", "audit"):
            code, text = self.firn(command, run)
            self.assertEqual(code, 0, text)

    def test_a_jet_whose_class_hangs_raises_or_dies_stops_the_print_by_name_and_is_safe(self):
        for how, words in list(FAILS.items())[:1 if SHORT else None]:
            with self.subTest(how):
                code, text, fakes, run = self.print_part(how)
                self.assertEqual(code, 3, text)
                self.assertIn("jet: kinds.py: Jet.arm: ", (run / "result.json").read_text())
                self.assertIn(words, json.loads((run / "result.json").read_text())["reason"])
                self.assertTrue(fakes["jet"].was_made_safe(), fakes["jet"].lines)
                self.assertEqual(self.firn("replay", run)[0], 0)


if __name__ == "__main__":
    ROOT, BUILD = (str(Path(word).resolve()) for word in sys.argv[1:3])
    SHORT = "short" in sys.argv[3:4]
    result = unittest.main(argv=sys.argv[:1] + sys.argv[3 + SHORT:], exit=False).result
    sys.exit(77 if result.skipped else not result.wasSuccessful())
