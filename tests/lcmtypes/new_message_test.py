#!/usr/bin/env python3
"""Adds a message in a scratch copy of the house, in the two places that CONTRIBUTING names, and asks for its mistakes.

    tests/lcmtypes/new_message_test.py ROOT COMPILER
"""
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = COMPILER = None

MESSAGE = """package firn;

// Power that the lamp takes.
struct lamp_power_t {
  header_t header;
  int32_t n;                  // [1, 4]; phases
  int32_t layer;
  double power_w;             // [0, 500]; (0, 500] while mode = kFull..kBoost; mean
  int8_t mode;                // enum LampPower {kOff = 0, kFull = 1,
                              // kBoost = 2}
  float phase_w[n];           // [-10, 500] or NaN
}
"""
ROW = "LAMP_POWER lamp_power_t lamp reliable 2 0 logged nodes power of the lamp\n"

PROBE = r"""
#include <cstdio>
#include <vector>
#include "firn/enums.h"
#include "firn/lamp_power_t.hpp"
#include "lcmtypes/channels.h"
#include "lcmtypes/schema.h"
#include "lcmtypes/validate.h"
#include "tests/lcmtypes/limit_rows.h"
using namespace firn;

std::vector<std::byte> bytes_of(const lamp_power_t& m) {
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}
void say(const lamp_power_t& m) {
  const auto said = validate(*find_channel(channels::kLampPower.name), bytes_of(m));
  std::puts(said ? said->c_str() : "fine");
}
int main() {
  const Channel<lamp_power_t> channel = channels::kLampPower;
  const ChannelInfo& row = *find_channel(channel.name);
  std::printf("%s %s %s %g %s\n", row.name.data(), row.type.data(), info(row.publisher).name.data(), row.rate_hz,
              row.meaning.data());
  lamp_power_t m{};
  m.header.seq = 1;
  m.n = 2;
  m.power_w = 12.5;
  m.mode = std::int8_t(LampPower::kBoost);
  m.phase_w = {1, 2};
  const std::vector<std::byte> sent = bytes_of(m);
  lamp_power_t got{};
  const bool decoded = got.decode(sent.data(), 0, int(sent.size())) == int(sent.size());
  std::printf("%d %g %d\n", decoded, got.power_w, got.mode);
  const schema::Type* type = Schema::builtin().find("lamp_power_t");
  std::printf("%d %s\n", type->fingerprint == lamp_power_t::getHash(), to_json(*type, sent).c_str());
  say(m);
  m.power_w = 0;
  say(m);
  m.mode = 4;
  say(m);
  m.mode = 1;
  m.power_w = 1;
  m.phase_w[1] = 501;
  say(m);
  std::printf("%zu %zu\n", unmatched_limits().size(), unlimited_members().size());
}
"""
EXPECTED = """LAMP_POWER lamp_power_t lamp 2 power of the lamp
1 12.5 2
1 {"header":{"run_id":0,"incarnation":0,"seq":1,"utime_us":0},"n":2,"layer":0,"power_w":12.5,"mode":2,"phase_w":[1,2]}
fine
LAMP_POWER: byte 44: power_w = 0 is outside above 0 up to 500 (while mode = 2)
LAMP_POWER: byte 52: mode = 4 is outside 0..2
LAMP_POWER: byte 57: phase_w[1] = 501 is outside -10..500
0 0
"""


class NewMessage(unittest.TestCase):
    def setUp(self):
        self.house = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.house)
        self.words = self.house / "lcmtypes"
        shutil.copytree(ROOT / "lcmtypes", self.words)
        (self.house / "core").symlink_to(ROOT / "core")
        (self.house / "tests").symlink_to(ROOT / "tests")
        self.out = self.house / "out"

    def add(self, message=MESSAGE, row=ROW):
        (self.words / "lamp_power_t.lcm").write_text(message)
        with open(self.words / "channels.table", "a") as table:
            table.write(row)

    def generate(self):
        files = sorted(str(p) for p in self.words.glob("*_t.lcm"))
        return subprocess.run([sys.executable, "-B", str(self.words / "generate.py"), str(self.house), str(self.out), *files],
                              capture_output=True, text=True)

    def refused(self, message=MESSAGE, row=ROW):
        self.add(message, row)
        done = self.generate()
        self.assertEqual(done.returncode, 1, done.stderr)
        return done.stderr.strip()

    def test_a_message_is_one_file_and_one_row(self):
        self.add()
        self.assertEqual(self.generate().returncode, 0)
        subprocess.run(["lcm-gen", "--cpp", "--cpp-std=c++11", f"--cpp-hpath={self.out}",
                        *(str(self.words / f"{t}_t.lcm") for t in ("header", "lamp_power"))], check=True)
        probe = self.house / "probe.cpp"
        probe.write_text(PROBE)
        sources = [self.out / "message_tables.cpp", probe]
        sources += [self.words / s for s in ("channels.cpp", "schema.cpp", "schema_json.cpp", "schema_parse.cpp",
                                             "schema_resolve.cpp", "utf8.cpp", "validate.cpp")]
        program = self.house / "probe"
        subprocess.run([COMPILER, "-std=c++20", "-O0", "-I", self.house, "-I", self.out, *sources, "-o", program],
                       check=True)
        self.assertEqual(subprocess.run([program], capture_output=True, text=True, check=True).stdout, EXPECTED)

    def test_a_number_without_a_range_is_refused(self):
        self.assertEqual(self.refused(MESSAGE.replace("[1, 4]; phases", "phases")),
                         "lcmtypes: lamp_power_t.lcm: n has no range; one is wanted, such as // [0, 127]")

    def test_a_range_that_cannot_be_read_is_refused(self):
        self.assertEqual(self.refused(MESSAGE.replace("[1, 4];", "[1, four];")),
                         "lcmtypes: lamp_power_t.lcm: n: '[1, four]' is neither range, relation nor enum")

    def test_a_condition_on_what_does_not_exist_is_refused(self):
        self.assertEqual(self.refused(MESSAGE.replace("while mode", "while mood")),
                         "lcmtypes: lamp_power_t.lcm: power_w: no member mood")
        self.assertEqual(self.refused(MESSAGE.replace("kFull..", "kEmpty.."), ""),
                         "lcmtypes: lamp_power_t.lcm: power_w: kEmpty is no value of mode")

    def test_an_enum_that_a_core_header_defines_must_have_its_values(self):
        self.assertEqual(self.refused(MESSAGE.replace("kBoost = 2}", "kBoost = 2} of core/grid/device.h")),
                         "lcmtypes: core/grid/device.h: enum class LampPower is not here")
        fault = self.words / "fault_t.lcm"
        fault.write_text(fault.read_text().replace("kWarning = 1", "kAlarm = 1"))
        self.assertEqual(self.refused(row=""),
                         "lcmtypes: fault_t.severity: the values of enum Severity are not those of core/grid/device.h")

    def test_an_enum_with_a_gap_is_refused(self):
        self.assertEqual(self.refused(MESSAGE.replace("kBoost = 2}", "kBoost = 4}")),
                         "lcmtypes: lamp_power_t.mode: the values of enum LampPower leave a gap")

    def test_a_row_without_its_message_is_refused(self):
        self.assertIn("there is no lamp_heat_t.lcm", self.refused(row=ROW.replace("lamp_power_t", "lamp_heat_t")))

    def test_a_row_with_an_unknown_word_is_refused(self):
        self.assertIn("delivery is often, not reliable or latest", self.refused(row=ROW.replace("reliable", "often")))


if __name__ == "__main__":
    ROOT, COMPILER = Path(sys.argv[1]).resolve(), sys.argv[2]
    unittest.main(argv=sys.argv[:1])
