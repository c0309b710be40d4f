#!/usr/bin/env python3
"""Adds a command in a scratch copy of the house, in the three places that CONTRIBUTING names, and runs it.

    tests/cli/new_command_test.py ROOT BUILD
"""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from scratch_copy import ScratchCopy, run  # noqa: E402

ROOT = BUILD = None

SOURCE = """// run_greet greets a guest.
#include "cli/commands.h"

#include <cstdio>

#include "cli/option_set.h"

namespace firn {
namespace {

struct GreetOptions {
  std::string guest;
  int times = 1;
  bool json = false;
};

int run_greet(const GreetOptions& o) {
  for (int n = 0; n < o.times; ++n)
    std::printf(o.json ? "{\\"hello\\":\\"%s\\"}\\n" : "hello %s\\n", o.guest.c_str());
  return 0;
}

}  // namespace

void declare_greet(OptionSet& options) {
  auto& o = options.calls(run_greet);
  options.option("GUEST", o.guest, "who comes").required();
  options.option("--times", o.times, "how often").show_default().within(1, 9);
  options.json_flag(o.json);
}

}  // namespace firn
"""


class NewCommand(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.copy = ScratchCopy(ROOT, self.folder.name)

    def tearDown(self):
        self.folder.cleanup()

    def test_a_new_command_is_a_row_in_each_of_three_files(self):
        self.copy.add("cli/greet_command.cpp", SOURCE)
        self.copy.insert("cli/CMakeLists.txt", "  generated_document.cpp", "  greet_command.cpp\n")
        self.copy.insert("cli/commands.h", "void declare_help", "void declare_greet(OptionSet& options);\n")
        self.copy.insert("cli/commands.cpp", 'constexpr Command kCommands[] = {', '    {"greet", "greets a guest", declare_greet},\n')
        self.assertEqual(self.copy.touched(), ["cli/CMakeLists.txt", "cli/commands.cpp", "cli/commands.h"])

        cache = (Path(BUILD) / "CMakeCache.txt").read_text()
        given = dict(line.split("=", 1) for line in cache.splitlines() if "=" in line and not line.startswith(("#", "/")))
        self.copy.configure(given["CMAKE_BUILD_TYPE:STRING"], "-DBUILD_TESTING=OFF", "-DFIRN_PCH=OFF",
                            f"-DFIRN_SANITIZE={given['FIRN_SANITIZE:STRING']}")
        objects = [f"cli/CMakeFiles/firn_cli.dir/{name}.cpp.o" for name in ("commands", "greet_command")]
        self.copy.compile(*objects)
        firn = self.copy.link(BUILD, "bin/firn", objects, Path(self.folder.name) / "greeter")

        def say(*words):
            done = subprocess.run([firn, *words], capture_output=True, text=True)
            return done.returncode, done.stdout, done.stderr

        self.assertIn("greet                       greets a guest", say("--help")[1])
        self.assertEqual(say("greet", "Ada", "--times", "2"), (0, "hello Ada\nhello Ada\n", ""))
        self.assertEqual(say("greet", "Ada", "--json"), (0, '{"hello":"Ada"}\n', ""))
        self.assertIn("--times INT:INT in [1 - 9]=1", say("greet", "--help")[1])
        for words, problem in (("greet",), "firn greet: GUEST is required"), \
                (("greet", "Ada", "--times", "10"), "firn greet: --times: Value 10 not in range 1 to 9"), \
                (("gret",), "unknown command 'gret'; the nearest known one is greet"):
            code, _, said = say(*words)
            self.assertEqual(code, 2)
            self.assertIn(problem, said)


if __name__ == "__main__":
    ROOT, BUILD = (str(Path(word).resolve()) for word in sys.argv[1:3])
    unittest.main(argv=sys.argv[:1])
