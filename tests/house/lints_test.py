#!/usr/bin/env python3
"""Every lint catches what it is for: a small tree that passes, then one planted violation each."""
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import check_docs  # noqa: E402
import check_house  # noqa: E402
import check_layers  # noqa: E402
import check_packages  # noqa: E402
import check_style  # noqa: E402
import check_test_share  # noqa: E402
from small_tree import SmallTree  # noqa: E402

GOOD = {
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.25)\nproject(firn VERSION 1.0 LANGUAGES CXX)\nfind_library(LCM_LIBRARY lcm REQUIRED)\n",
    "firn": "cmake -G Ninja\n",
    "core/grid/CMakeLists.txt": "firn_library(firn_grid grid.cpp)\n",
    "core/grid/grid.h": "#pragma once\n#include <vector>\n",
    "core/grid/grid.cpp": '#include "core/grid/grid.h"\n// a thread? std::thread in a comment is none\nint x = 1;\n',
    "core/control/CMakeLists.txt": "firn_library(firn_control mpc.cpp LINK firn_grid)\n",
    "core/control/mpc.cpp": '#include "core/grid/grid.h"\nconst char* text = "std::rand() <chrono>";\n',
    "runtime/CMakeLists.txt": "firn_library(firn_runtime node.cpp)\n",
    "runtime/node.h": "#pragma once\n",
    "runtime/node.cpp": '#include "runtime/node.h"\n#include "firn/tile_t.hpp"\n#include <chrono>\n',
    "config/experiment.h": "#pragma once\n",
    "plant/CMakeLists.txt": "firn_library(firn_plant world.cpp world/setup.cpp main.cpp)\n",
    "plant/world.cpp": '#include "core/grid/grid.h"\n',
    "plant/world/setup.cpp": '#include "config/experiment.h"\n#include <chrono>\n',
    "plant/main.cpp": '#include "config/experiment.h"\nint main() {}\n',
    "procs/CMakeLists.txt": "firn_library(firn_node_stage stage/node.cpp LINK firn_runtime)\n"
                            "firn_process(stage stage/main.cpp LINK firn_node_stage firn_bus)\n",
    "procs/stage/node.h": "#pragma once\n",
    "procs/stage/node.cpp": '#include "procs/stage/node.h"\n#include "runtime/node.h"\n'
                            "#include <unordered_map>\nint f(const std::unordered_map<int, int>& m) { return m.count(1); }\n",
    "procs/stage/main.cpp": '#include "procs/bus/bus.h"\nint main() {}\n',
    "procs/bus/CMakeLists.txt": "firn_library(firn_bus bus.cpp LINK firn_runtime)\n",
    "procs/bus/bus.h": "#pragma once\n",
    "procs/bus/bus.cpp": "#include <lcm/lcm-cpp.hpp>\n#include <thread>\n",
    "replay/CMakeLists.txt": "firn_library(firn_replay audit.cpp)\n",
    "replay/audit.cpp": '#include "procs/stage/node.h"\nfirn::sim_truth_t truth;\n',
    "lcmtypes/tile_t.lcm": "struct tile_t {}\n",
    "lcmtypes/CMakeLists.txt": "firn_lcm_types(firn_lcm_headers)\n",
    "tests/core/CMakeLists.txt": "firn_test(test_grid grid_test.cpp LINK firn_grid)\n",
    "tests/core/grid_test.cpp": '#include "core/grid/grid.h"\nTEST_CASE("A grid is a grid") { CHECK(true); }\n',
    "scripts/packages.txt": "cmake\nninja-build  # builds\ng++\nliblcm-dev\n",
}


class Lints(SmallTree):
    GOOD = GOOD

    def problems(self):
        found = check_layers.check_includes(self.root) + check_layers.check_circles(self.root) + check_layers.check_links(self.root)
        found += check_style.check_columns(self.root) + check_style.check_commas(self.root)
        for check in check_house.CHECKS:
            found += check(self.root)
        return found + check_packages.check_needed(self.root) + check_packages.check_used(self.root)

    def caught(self, path, text, *words):
        """Planting `text` at the end of `path` gives exactly the problem that names the file and the words."""
        before = GOOD.get(path, "")
        self.write(path, before + text)
        found = self.problems()
        self.assertTrue(found, f"nothing caught in {path}: {text!r}")
        for word in (path,) + words:
            self.assertTrue(any(word in problem for problem in found), f"{word!r} not in {found}")
        self.write(path, before)

    def test_the_good_tree_passes(self):
        self.assertEqual(self.problems(), [])

    def test_includes_against_the_arrows(self):
        forbidden = {
            "core/grid/grid.cpp": ("core/control/mpc.h", "runtime/node.h"),
            "core/control/mpc.cpp": ("config/experiment.h",),
            "runtime/node.cpp": ("core/control/mpc.h", "procs/bus/bus.h"),
            "plant/world.cpp": ("config/experiment.h", "core/control/mpc.h", "drivers/robot/fvp.h"),
            "procs/stage/node.cpp": ("procs/bus/bus.h", "procs/jet/node.h", "replay/audit.h"),
            "replay/audit.cpp": ("procs/bus/bus.h", "procs/stage/inner.h"),
        }
        for targets in forbidden.values():
            for target in targets:
                self.write(target, GOOD.get(target, "#pragma once\n"))
        for path, targets in forbidden.items():
            for target in targets:
                self.caught(path, f'#include "{target}"\n', target)

    def test_includes_that_are_not_full_paths(self):
        self.caught("core/grid/grid.cpp", '#include "grid.h"\n', "not a full path")
        self.caught("core/grid/grid.cpp", "#include <core/grid/grid.h>\n", "in quotes")

    def test_heavy_headers_and_lcm(self):
        self.caught("runtime/node.h", "#include <toml++/toml.h>\n", "heavy")
        self.write("files/json.h", "#pragma once\n")
        self.caught("print/labs/lab.h", '#include "files/json.h"\n', "heavy")
        self.caught("print/labs/lab.cpp", "#include <nlohmann/json.hpp>\n", "compiled once")
        self.caught("core/grid/grid.h", "#include <Eigen/Dense>\n", "heavy")
        self.caught("runtime/node.cpp", "#include <lcm/lcm-cpp.hpp>\n", "only procs/bus")

    def test_links_against_the_arrows(self):
        self.caught("core/grid/CMakeLists.txt", "firn_library(firn_more grid.cpp LINK firn_control)\n", "firn_control")
        self.caught("runtime/CMakeLists.txt", "firn_library(firn_more node.cpp PRIVATE_LINK firn_bus)\n", "firn_bus")
        self.write("drivers/CMakeLists.txt", "firn_library(firn_drivers robot/fvp.cpp)\n")
        self.caught("plant/CMakeLists.txt", "firn_library(firn_more world.cpp LINK firn_drivers)\n", "firn_drivers")
        self.caught("procs/CMakeLists.txt", "firn_library(firn_more stage/node.cpp LINK firn_bus)\n", "firn_bus")

    def test_circles_of_libraries(self):
        self.caught("core/grid/CMakeLists.txt",
                    "firn_library(firn_lower map.cpp LINK firn_upper)\nfirn_library(firn_upper grid.cpp PRIVATE_LINK firn_lower)\n",
                    "a circle of libraries: firn_lower -> firn_upper -> firn_lower")
        # By a property of the program that links them.
        self.caught("core/grid/CMakeLists.txt",
                    "firn_library(firn_lower map.cpp LINK $<IF:$<BOOL:$<TARGET_PROPERTY:TABLES>>,x,firn_upper>)\n"
                    "firn_library(firn_upper grid.cpp LINK firn_lower)\n", "a circle of libraries")

    def test_circles_of_folders(self):
        self.write("core/control/mpc/mpc.h", "#pragma once\n")
        self.write("core/control/mpc/mpc.h", '#pragma once\n#include "core/control/options.h"\n')
        self.write("core/control/options.h", "#pragma once\n")
        self.assertEqual(self.problems(), [])
        self.caught("core/control/mpc.cpp", '#include "core/control/mpc/mpc.h"\n', "a circle of folders")

    def test_the_table_of_layers_in_the_architecture(self):
        page = "docs/architecture.md"
        self.assertEqual(check_layers.check_page(self.root), [])  # no page, no table
        self.write(page, "# Architecture\n")
        self.assertIn("is not that of scripts/check_layers.py", check_layers.check_page(self.root)[0])
        self.write(page, "# Architecture\n<!-- layers -->\n<!-- end -->\nMore.\n")
        silent = check_layers.check_page(self.root, write=True)
        self.assertEqual(silent, [f"{page}: no word about {room}" for room in check_layers.ALLOWED])
        made = (self.root / page).read_text(encoding="utf-8")
        self.assertTrue(made.endswith("<!-- end -->\nMore.\n"))
        told = made.replace("`||", "`|words|")
        self.write(page, told)
        self.assertEqual(check_layers.check_page(self.root), [])
        self.assertEqual(check_layers.check_page(self.root, write=True), [])
        self.assertEqual((self.root / page).read_text(encoding="utf-8"), told)
        for true, false in (("|`plant`|words|*leaves*, `files`, `firmware`, `plant/options`|", "|`plant`|words|*leaves*|"), ("|`core/grid`|words|`core/options`, `core/exact`|\n", ""),
                            ("|`plant/main.*`|", "|`plant/gone.*`|"), ("- *leaves*: `core/options`,", "- *leaves*:")):
            self.assertIn(true, told)
            self.write(page, told.replace(true, false))
            self.assertEqual(len(check_layers.check_page(self.root)), 1, true)

    def test_long_lines_and_statements_joined_by_commas(self):
        self.caught("runtime/node.cpp", "// " + "x" * 108 + "\n", "111 columns")
        self.write("runtime/node.cpp", GOOD["runtime/node.cpp"] + 'const char* css = R"css(' + "x" * 200 + ')css";\n')
        self.assertEqual(self.problems(), [])
        for joined in ("a = 1, b = 2;", "if (a) f(), ++b;", "for (int i = 0, j = 0; i < 2; ++i, ++j) x += i, y += j;", "return f(a, b), c;"):
            self.caught("runtime/node.cpp", "void f() { " + joined + " }\n", "joined by a comma")
        for fine in ("int a = 1, b = 2;", "f(a, b);", "auto g = [a, b] { return std::pair{a, b}; };", "std::array<int, 2> x{1, 2};",
                     "return f<A, B>(x);", "for (i = 0, j = 1; i < j; ++i, --j) f(i);"):
            self.write("runtime/node.cpp", GOOD["runtime/node.cpp"] + "void f() { " + fine + " }\n")
            self.assertEqual(self.problems(), [], fine)

    def test_what_would_change_the_bytes(self):
        for line, word in (("#include <chrono>", "clock"), ("#include <thread>", "thread"), ("static std::mutex m; std::thread t;", "thread"),
                           ("auto t = std::chrono::steady_clock::now();", "clock"), ("int r = rand();", "randomness"),
                           ("std::mt19937 g;", "randomness"), ("std::normal_distribution<> d;", "distribution"),
                           ("std::shuffle(a, b, g);", "shuffle"), ("opt.set_maxtime(1.0);", "time limit"),
                           ("#include <fstream>", "file"), ('getenv("HOME");', "environment"), ("usleep(10);", "sleeping"),
                           ("cv::setNumThreads(2);", "thread")):
            for path in ("core/grid/grid.cpp", "procs/stage/node.cpp"):
                self.caught(path, line + "\n", word)
        self.caught("plant/world.cpp", "#include <random>\n", "randomness")

    def test_inexact_functions_in_nodes(self):
        self.caught("procs/stage/node.cpp", "double y = std::exp(x);\n", "inexact")
        self.caught("core/control/mpc.cpp", "double y = pow (x, 2);\n", "inexact")

    def test_iteration_over_unordered_containers(self):
        self.caught("procs/stage/node.cpp", "std::unordered_map<int, int> a;\nvoid g() { for (auto& x : a) h(x); }\n", "unordered container a")
        self.caught("core/grid/grid.cpp", "std::unordered_set<std::string> names;\nauto b = names.begin();\n", "unordered container names")

    def test_sizes(self):
        self.caught("runtime/node.cpp", "// line\n" * 600, "the limit is 600")
        self.caught("procs/stage/main.cpp", "// line\n" * 60, "the limit is 60")

    def test_unfinished_work_and_private_paths(self):
        for text in ("// TODO later\n", "// FIXME\n", "/* placeholder */\n", 'const char* p = "/home/me/x";\n'):
            self.caught("runtime/node.cpp", text)
        self.caught("tests/core/grid_test.cpp", 'TEST_CASE("A hidden one", "[.]") { CHECK(false); }\n', "hidden")
        self.caught("tests/core/grid_test.cpp", 'TEST_CASE("An empty one") {}\n', "empty")

    def test_names_that_page_and_browser_share(self):
        root = Path(__file__).resolve().parent.parent.parent
        for path in ("page/protocol.py", "page/protocol.table", "report/draw/error_colours.inc", "web/src/generated/protocol.ts"):
            self.write(path, (root / path).read_text(encoding="ascii"))
        self.assertEqual(check_house.check_protocol(self.root), [])
        self.write("page/protocol.table", (root / "page/protocol.table").read_text() + "number MapLate 16 flag\n")
        self.assertRegex(check_house.check_protocol(self.root)[0], "^web/src/generated/protocol.ts: is not what")
        for path in ("page/protocol.py", "page/protocol.table", "web/src/generated/protocol.ts"):
            (self.root / path).unlink()

    def test_sources_that_are_not_built(self):
        self.caught("core/grid/lost.cpp", "int y;\n", "stands in no CMakeLists.txt")
        self.caught("tests/core/lost_test.cpp", "int y;\n", "stands in no CMakeLists.txt")
        self.caught("runtime/lost_t.lcm", "struct lost_t {}\n", "stands in no CMakeLists.txt")
        (self.root / "core/grid/lost.cpp").unlink()

    def test_file_names_of_a_run_folder(self):
        for text in ('p = run / "nodes" / name;\n', 'if (e == ".wal") f();\n', 'p = d + "/experiment.toml";\n', 'p = r / "world" / "state";\n',
                     'n = "nodes/jet.wal";\n', 'f(run / "log.lcm");\n', 'f(run / "provenance.json");\n', 'f("result.json");\n', 'f("world.rec");\n'):
            self.caught("runtime/node.cpp", text, "files/run_paths.h names the files of a run")
            self.write("files/run_paths.h", "#pragma once\n" + text)
            self.assertEqual(self.problems(), [])
        self.write("runtime/node.cpp", GOOD["runtime/node.cpp"] + 'f("log.lcm is missing", j["inputs"], beside / "world");\n')
        self.assertEqual(self.problems(), [])

    def test_messages_that_begin_with_any_bytes(self):
        self.caught("core/grid/grid.cpp", "void f() {\n  tile_t tile;\n}\n", "tile_t tile; a message is made with {}")
        self.caught("core/grid/grid.cpp", "namespace firn::slice {\nstruct A {};\n}\n", "namespace firn::slice names no folder")

    def test_members_of_messages_that_are_reserved_words(self):
        for word in ("class", "lambda", "synchronized", "restrict", "None"):
            self.caught("lcmtypes/other_t.lcm", f"package firn;\n\nstruct other_t {{\n  int32_t n;  // of pass\n  double {word}[n];\n}}\n",
                        f"5: {word} is a reserved word")
        self.write("lcmtypes/other_t.lcm", "package firn;\n\nstruct other_t {\n  int32_t n;  // int32_t class;\n  double classes[n];\n}\n")
        self.assertEqual(self.problems(), [])

    def test_numbers_that_are_read_by_hand(self):
        for call in ("std::from_chars(a, b, v);", "v = std::stoi(text);", "v = strtod(at, &end);", 'sscanf(text, "%d", &v);'):
            self.caught("core/grid/grid.cpp", f"void f() {{\n  {call}\n}}\n", "read it with core/options/number.h")
        self.write("core/grid/grid.cpp", GOOD["core/grid/grid.cpp"] + "void g() { whole_number<int>(text); }\n")
        self.assertEqual(self.problems(), [])

    def test_tables_of_words_without_a_size(self):
        table = 'constexpr const char* kWords[] = {"",\n                                  "a"};\n'
        uses = "const char* f(Kind k) { return kWords[std::size_t(k)]; }\n"
        self.caught("core/grid/grid.cpp", table + uses, "kWords is read by a number, and no static_assert compares its size")
        self.caught("core/grid/grid.cpp", table.replace("const char* kWords[]", "std::array kWords") + "auto f(int k) { return kWords.at(k); }\n",
                    "kWords is read by a number")
        self.write("core/grid/grid.cpp", GOOD["core/grid/grid.cpp"] + table + "static_assert(std::size(kWords) == kTableSize<Kind>);\n" + uses)
        self.assertEqual(self.problems(), [])

    def test_types_of_one_name(self):
        cell = "namespace firn {\nstruct Cell {\n};\n}  // namespace firn\n"
        self.write("core/grid/grid.h", GOOD["core/grid/grid.h"] + cell)
        hidden = "namespace firn {\nnamespace {\nstruct Cell {\n};\n}  // namespace\n}  // namespace firn\n"
        for other in (hidden, cell.replace("namespace firn", "namespace firn::control")):
            self.write("core/control/mpc.cpp", GOOD["core/control/mpc.cpp"] + other)
            self.assertEqual(self.problems(), [])
        self.caught("core/control/mpc.cpp", cell, "firn::Cell is another type in core/grid/grid.h")
        driver = cell.replace("namespace firn", "namespace firn::drivers")
        self.caught("core/control/mpc.cpp", driver, "firn::drivers::Cell has the name of firn::Cell in core/grid/grid.h")

    def test_classes_in_many_sources(self):
        def grid_with(*members):
            listed = ["grid.cpp"]
            for n, (member, space) in enumerate(members):
                listed.append(f"part{n}.cpp")
                self.write(f"core/grid/part{n}.cpp", f"namespace {space} {{\n\n{member} {{\n  Cell::count(1);\n}}\n\n}}  // namespace {space}\n")
            self.write("core/grid/CMakeLists.txt", f"firn_library(firn_grid {' '.join(listed)})\n")
            return [problem for problem in self.problems() if "sources" in problem]
        free = ("Cell area(const Cell& of)", "firn")
        once, twice = ("void Cell::grow(int by)", "firn"), ("Cell::Cell(int a) : a_(a)", "firn")
        self.assertEqual(grid_with(once, twice, free), [])
        self.assertEqual(grid_with(once, twice, ("void Cell::grow(int by)", "firn::drivers")), [])  # another Cell
        self.assertEqual(grid_with(once, twice, ("void Row::add(const Cell& c)", "firn")), [])
        for third in ("Cell::~Cell()", "std::optional<Cell::Kind> Cell::kind(std::size_t n) const", "Cell& Cell::operator+=(int by)",
                      "std::function<void(int)> Cell::later()", "template <typename T> T Cell::as() const", "void Cell::Side::turn()",
                      "bool operator==(const Cell& a, int b) {\n  return false;\n}\n\nbool Cell::empty() const"):
            found = grid_with(once, twice, (third, "firn"))
            self.assertEqual(found, ["core/grid/part0.cpp: firn::Cell has members in 3 sources, the limit is 2: core/grid/part1.cpp, "
                                     "core/grid/part2.cpp too"], third)
        for n in range(3):
            (self.root / f"core/grid/part{n}.cpp").unlink()

    def test_hidden_functions_of_one_name(self):
        hidden = "namespace firn {\nnamespace {\n\nint twice(int a) { return 2 * a; }\n\n}  // namespace\n}  // namespace firn\n"
        self.write("core/grid/grid.cpp", GOOD["core/grid/grid.cpp"] + hidden)
        self.write("core/grid/CMakeLists.txt", "firn_library(firn_grid grid.cpp lines.cpp)\n")
        for other in ("(int a, int b)", "(std::pair<int, int> a, int b)", "()"):
            self.write("core/grid/lines.cpp", hidden.replace("(int a)", other))
            self.assertNotIn("twice", " ".join(self.problems()))
        self.write("core/control/mpc.cpp", GOOD["core/control/mpc.cpp"] + hidden)  # another target
        self.assertNotIn("twice", " ".join(self.problems()))
        for same in ("(int b)", "(const std::pair<int, int>& a)", "(std::span<const int> a)"):
            self.write("core/grid/lines.cpp", hidden.replace("(int a)", same))
            self.assertTrue(any("twice, a hidden function of 1 parameter(s), stands in core/grid/lines.cpp too" in p
                                for p in self.problems()), same)
        self.write("core/grid/CMakeLists.txt", "firn_alone(lines.cpp)\nfirn_library(firn_grid grid.cpp lines.cpp)\n")
        self.assertEqual(self.problems(), [])
        (self.root / "core/grid/lines.cpp").unlink()

    def test_readers_of_the_truth(self):
        self.caught("procs/stage/node.cpp", "subscribe(channels::kSimTruth, this);\n", "SIM_TRUTH")
        self.write("print/CMakeLists.txt", "firn_library(firn_print print.cpp)\n")
        self.write("print/print.cpp", "out.send(channels::kSimTruth, truth);\n")  # publishing is its job
        self.assertEqual(self.problems(), [])
        self.caught("print/print.cpp", "sim_truth_t truth; truth.decode(bytes, 0, n);\n", "SIM_TRUTH")

    def test_rooms_with_few_tests(self):
        def of_cli():
            return [problem for problem in check_test_share.check_shares(self.root) if problem.startswith("cli")]
        line = "int x;\n// a comment\n\n"
        self.write("cli/main.cpp", line * 100)
        self.write("tests/cli/main_test.cpp", line * 60)
        self.assertEqual(of_cli(), [])
        self.write("tests/cli/main_test.cpp", line * 59 + "// a comment\n" * 10)
        self.assertEqual(of_cli(), ["cli: 59 lines of tests by 100 of sources is 0.59, the least is 0.6"])

    def test_packages(self):
        self.caught("CMakeLists.txt", "find_package(OpenSSL REQUIRED)\n", "libssl-dev is missing")
        self.caught("CMakeLists.txt", "find_library(F frobnicate REQUIRED)\n", "knows no package")
        self.caught("CMakeLists.txt", "firn_find_headers(F hdf5.h libhdf5-dev)\n", "libhdf5-dev is missing")
        self.caught("scripts/packages.txt", "libeigen3-dev\n", "nothing uses it")
        self.caught("scripts/packages.txt", "libfrob-dev\n", "does not know")
        self.write("core/grid/solve.h", "#pragma once\n")
        self.write("core/grid/grid.cpp", "#include <cvode/cvode.h>\n")
        self.assertTrue(any("libsundials-dev is missing" in p for p in self.problems()))


DOCS = {
    "README.md": "# House\n[docs](docs/README.md), `core/grid/grid.h`\n\n```\n./firn print experiments/a.toml --set grid.nx=3\n```\n",
    "CONTRIBUTING.md": "# Rules\n",
    "docs/README.md": "# Index\n[pages](commands/print.md#exit-codes), [keys](configuration.md)\n",
    "docs/commands/print.md": "# Print\n![a](../images/a.svg)\n\n## Exit codes\n`build/bin/firn print --seeds 3`, `build/tests/test_grid \"A grid*\"`,\n"
                              "`core/{grid,path}/*.h`, `core/grid/grid`, `experiments/mine.toml`\n",
    "docs/configuration.md": "# Keys\n\n## [grid], [other]\n\n|key|default|\n|-|-|\n|nx, ny|40|\n",
    "docs/images/a.svg": "<svg/>\n",
    "cli/print_command.cpp": '#include "x.h"\napp.add_option("-s,--seeds", o->seeds);\napp.add_option("--set", o->set);\n',
    "core/grid/grid.h": "// See docs/commands/print.md.\n",
    "core/path/path.h": "\n",
    "experiments/a.toml": "# docs/configuration.md\n",
    "cli/CMakeLists.txt": "firn_process(firn main.cpp)\n",
    "tests/core/CMakeLists.txt": "firn_test(test_grid grid_test.cpp)\n",
    "tests/core/grid_test.cpp": 'TEST_CASE(\n    "A grid is "\n    "a grid") {}\n',
}


class DocsLint(SmallTree):
    GOOD = DOCS

    def problems(self):
        return [problem for check in check_docs.CHECKS for problem in check(self.root)]

    def caught(self, path, text, *words):
        """Planting `text` at the end of `path` gives one problem, which holds the words."""
        self.write(path, DOCS.get(path, "") + text)
        found = self.problems()
        self.assertEqual(len(found), 1, f"{path}: {text!r} gave {found}")
        for word in words:
            self.assertIn(word, found[0])
        self.write(path, DOCS[path]) if path in DOCS else (self.root / path).unlink()

    def test_the_good_tree_passes(self):
        self.assertEqual(self.problems(), [])

    def test_links(self):
        self.caught("README.md", "[gone](docs/gone.md)\n", "README.md:7", "gone.md")
        self.caught("docs/README.md", "[part](commands/print.md#gone)\n", "no heading #gone")
        self.write("docs/README.md", DOCS["docs/README.md"] + "`[code](is/no/link.md)`, [web](https://example.org/x)\n")
        self.assertEqual(self.problems(), [])

    def test_pages_and_pictures_that_nothing_leads_to(self):
        self.caught("docs/lost.md", "# Lost\n[index](README.md)\n", "docs/lost.md", "not linked")
        self.caught("docs/images/lost.png", "", "no page shows it")

    def test_tables_cut_by_an_empty_line(self):
        self.caught("docs/README.md", "\n|a|b|\n|-|-|\n|1|2|\n\n|3|4|\n", "docs/README.md:8", "without the table's head")

    def test_named_files(self):
        self.caught("docs/README.md", "`core/grid/gone.h`\n", "docs/README.md:3", "core/grid/gone.h")
        self.caught("docs/README.md", "in core/{grid,gone}/*.h\n", "core/gone/*.h")
        self.caught("core/path/path.h", "// docs/gone.md\n", "core/path/path.h:2", "docs/gone.md")
        self.caught("experiments/a.toml", "# docs/gone.md\n", "experiments/a.toml:2")

    def test_paths_in_comments(self):
        self.caught("core/path/path.h", "/// As in core/grid/gone.h.\n", "core/path/path.h:2", "core/grid/gone.h")
        self.caught("core/path/path.h", "/* in\n   core/gone/path */\n", "core/path/path.h:3", "core/gone/path")
        self.caught("core/path/path.h", "int x;  // core/{grid,gone}/*.h\n", "core/gone/*.h")
        self.caught("core/path/path.h", "// runs/read/gone.h\n", "runs/read/gone.h")
        self.caught("experiments/a.toml", 'a = "#"  # as core/gone.h\n', "experiments/a.toml:2", "core/gone.h")
        self.caught("cmake/lists.cmake", "# core/gone\n", "cmake/lists.cmake:1", "core/gone")
        self.caught("core/CMakeLists.txt", "f(grid/grid.cpp)  # tests/core/gone_test.cpp\n", "core/CMakeLists.txt:1")
        self.caught("scripts/make.py", '#!/usr/bin/env python3\n"""Makes\n\n    scripts/gone.py\n"""\n', "scripts/make.py:4", "scripts/gone.py")
        for fine in ("// core/grid/grid, core/grid/ and core/{grid,path}/*.h\n", "// core/NAME/X.h, core/path/my-mine.h\n",
                     "// nodes/stage.wal, runs/gone/log.lcm, build/core/gone.h\n", 'auto a = "core/gone.h"; int b = 1 / 2;\n',
                     'auto a = R"(// core/gone.h)";\n', "// tests/web/node_modules/vite\n"):
            self.write("core/path/path.h", DOCS["core/path/path.h"] + fine)
            self.assertEqual(self.problems(), [], fine)
        self.write("core/path/path.h", DOCS["core/path/path.h"])
        self.write("scripts/make.py", 'TEXT = """#include "core/gone.h"\n# core/gone.h\n"""\n')
        self.assertEqual(self.problems(), [])

    def test_programs_and_tests(self):
        self.caught("docs/README.md", "`build/bin/gone`\n", "nothing makes build/bin/gone")
        self.caught("docs/README.md", "`build/bench/gone 3`\n", "nothing makes build/bench/gone")
        self.caught("docs/README.md", "`build/tests/test_grid \"A cell*\"`\n", "no test is called \"A cell*\"")

    def test_commands_options_and_keys(self):
        self.caught("docs/README.md", "```\n./firn pint x\n```\n", "no command pint")
        self.caught("docs/README.md", "    firn print x --sedes 3\n", "no command has the option --sedes")
        self.caught("docs/README.md", "`firn print x\n--sedes 3`\n", "no command has the option --sedes")
        self.caught("docs/README.md", "`firn print x --set grid.nz=1`\n", "there is no key grid.nz")
        self.write("docs/README.md", DOCS["docs/README.md"] + "`firn print x --set other.ny=1`, `firn COMMAND`, a firn hand\n")
        self.assertEqual(self.problems(), [])

    def test_interlocks(self):
        row = "# Safety\n\n|code|what|tests|\n|-|-|-|\n|6|low|test_core|\n"
        self.write("docs/README.md", DOCS["docs/README.md"] + "[s](safety.md)\n")
        self.write("docs/safety.md", row)
        self.assertIn("docs/safety.md:5: interlock 6 names ['test_core']", self.problems()[0])
        self.write("tests/core/low_test.cpp", 'TEST_CASE("it is low",\n          "[grid][I6]") {}\n')
        self.assertEqual(self.problems(), [])
        self.write("docs/safety.md", row.replace("test_core", "test_procs"))
        self.assertIn("tagged [I6] are in ['test_core']", self.problems()[0])
        self.write("docs/safety.md", row.replace("|6|", "|7|"))
        self.assertEqual(len(self.problems()), 2)
        self.write("docs/safety.md", row)
        self.write("page/event_words.cpp", 'constexpr InterlockWords kTable[] = {\n    {5, "high",\n     "wait"},\n};\n')
        self.assertEqual(self.problems(), ["page/event_words.cpp: has no words for interlock [I6]"])


if __name__ == "__main__":
    unittest.main()
