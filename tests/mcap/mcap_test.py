#!/usr/bin/env python3
"""An exported .mcap, read by npm's @mcap/core, holds every message of the log.

    tests/mcap/mcap_test.py FIRN ROOT [Case.test]

The package is installed into tests/mcap/node_modules first, once for each lockfile; a machine without node, npm or npm's registry
skips (exit code 77).
"""
import hashlib
import json
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
HERE = ROOT / "tests" / "mcap"
sys.path.insert(0, str(ROOT / "tests" / "web"))
sys.dont_write_bytecode = True
from web_test import install, skip  # noqa: E402

RUNS = ("v1-mpc", "v2-two-inks", "v5-ice")


def raw_messages(log):
    """number -> payload of each event of an LCM log."""
    found, at = {}, 0
    while at < len(log):
        _, number, _, channel, size = struct.unpack_from(">IqqII", log, at)
        found[number] = log[at + 28 + channel:at + 28 + channel + size]
        at += 28 + channel + size
    return found


class ByItsMakersLibrary(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.file = Path(self.scratch.name) / "run.mcap"

    def tearDown(self):
        self.scratch.cleanup()

    def read(self):
        return subprocess.run(["node", HERE / "read.mjs", self.file], cwd=HERE, capture_output=True, text=True)

    def test_every_message_is_there_as_json_and_as_lcm(self):
        for name in RUNS:
            run = ROOT / "tests" / "replay" / "golden" / name
            subprocess.run([FIRN, "export", run, "-o", self.file], check=True, capture_output=True)
            done = self.read()
            self.assertEqual(done.returncode, 0, done.stderr[-2000:])
            *messages, rest = map(json.loads, done.stdout.splitlines())
            lines = subprocess.run([FIRN, "log", "cat", run / "log.lcm", "--full"], check=True, capture_output=True, text=True).stdout
            logged = {event["event"]: event for event in map(json.loads, lines.splitlines())}
            raw = raw_messages((run / "log.lcm").read_bytes())
            own = [m for m in messages if not m["topic"].startswith("/foxglove/")]
            self.assertEqual(len(own), 2 * len(logged))
            self.assertEqual({m["schema"] for m in messages} - {m["schema"] for m in own}, {"foxglove.Grid", "foxglove.Log"})
            for m in own:
                event = logged[m["sequence"]]
                self.assertEqual(int(m["time_ns"]), 1000 * event["utime_us"])
                self.assertEqual(m["schema"], "firn." + event["type"])
                self.assertEqual(m["topic"], ("/" if "message" in m else "/lcm/") + event["channel"])
                if "message" in m:
                    self.assertEqual(m["message"], event["message"])
                else:
                    self.assertEqual(m["sha256"], hashlib.sha256(raw[m["sequence"]]).hexdigest())
            self.assertTrue(rest["done"])
            self.assertEqual(int(rest["statistics"]), len(messages))
            self.assertEqual(rest["attachments"]["experiment.toml"], (run / "experiment.toml").read_text())
            self.file.unlink()

    def test_a_changed_byte_of_a_chunk_is_found_by_its_checksum(self):
        subprocess.run([FIRN, "export", ROOT / "tests" / "replay" / "golden" / RUNS[0], "-o", self.file], check=True, capture_output=True)
        data = bytearray(self.file.read_bytes())
        data[len(data) // 3] ^= 1
        self.file.write_bytes(data)
        done = self.read()
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("CRC", done.stderr)


if __name__ == "__main__":
    if not shutil.which("node"):
        skip("node", "there is no node on this machine")
    install(HERE)
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
