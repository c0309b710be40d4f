#!/usr/bin/env python3
"""Violations that no expression over one line finds, each planted alone and found by name: in object files, in clang's
tree, in the structure of a test."""
import json
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import check_ast  # noqa: E402
import check_house  # noqa: E402
import check_links  # noqa: E402
import check_names  # noqa: E402
import check_symbols  # noqa: E402
import check_tests  # noqa: E402
from small_tree import SmallTree  # noqa: E402

# A node, what it is linked with, and beside it a room that may read clocks.
GOOD = {
    "core/grid/grid.h": "#pragma once\nnamespace firn {\nint cells(int n);\n}  // namespace firn\n",
    "core/grid/grid.cpp": '#include "core/grid/grid.h"\nnamespace firn {\nint cells(int n) { return n * n; }\n}  // namespace firn\n',
    "core/control/mpc.cpp": '#include "core/grid/grid.h"\nnamespace firn {\nstatic const int kMost = 7;\n'
                            "int plan(int n) { return cells(n) + kMost; }\n}  // namespace firn\n",
    "files/log.cpp": "#include <ctime>\nnamespace firn {\nlong stamp() { return time(nullptr); }\n}  // namespace firn\n",
    "procs/stage/node.cpp": "namespace firn {\nint plan(int n);\nint decide(int n) { return plan(n); }\n}  // namespace firn\n",
    "procs/stage/main.cpp": "namespace firn {\nlong stamp();\n}\nint main() { return int(firn::stamp()); }\n",
    "tests/core/grid_test.cpp": 'TEST_CASE("a grid has cells") { CHECK(firn::cells(2) == 4); }\n',
}

SYMBOLS = {
    "time() through a using declaration":
        ("#include <ctime>\nusing ::time;\nlong f() { return time(nullptr); }\n", "a clock (time)"),
    "clock() by a declaration of its own": ('extern "C" long clock();\nlong f() { return clock(); }\n', "a clock (clock)"),
    "a clock of std::chrono through an alias":
        ("#include <chrono>\nusing Ticks = std::chrono::steady_clock;\nauto f() { return Ticks::now(); }\n", "a clock (_ZNSt6chrono"),
    "__builtin_exp": ("double f(double x) { return __builtin_exp(x); }\n", "an inexact function, whose last bit depends on the CPU (exp)"),
    "std::exp of a float, as a template's argument":
        ("#include <cmath>\ntemplate <float (*F)(float)>\nfloat apply(float x) { return F(x); }\n"
         "float f(float x) { return apply<std::exp>(x); }\n", "(expf)"),
    "a power by a function pointer":
        ("#include <cmath>\ndouble (*const volatile power)(double, double) = std::pow;\ndouble f(double x) { return power(x, x); }\n", "(pow)"),
    "a thread through an alias":
        ("#include <thread>\nusing Worker = std::jthread;\nvoid f() { Worker w([] {}); }\n", "a thread (_ZNSt6thread"),
    "a pool's thread by pthread": ('#include <pthread.h>\nvoid f(pthread_t t) { pthread_detach(t); }\n', "a thread (pthread_detach)"),
    "sleeping behind a macro": ("#include <unistd.h>\n#define WAIT(x) usle##x\nvoid f() { WAIT(ep)(10); }\n", "sleeping (usleep)"),
    "std::random_device through using":
        ("#include <random>\nusing Entropy = std::random_device;\nunsigned f() { return Entropy()(); }\n", "randomness that is not keyed"),
    "rand() pasted from two halves": ("#include <cstdlib>\n#define JOIN(a, b) a##b\nint f() { return JOIN(ra, nd)(); }\n", "(rand)"),
    "a time limit by a pointer to the function":
        ('extern "C" int nlopt_set_maxtime(void*, double);\nauto limit = &nlopt_set_maxtime;\nint f(void* o) { return limit(o, 1.0); }\n',
         "a time limit (nlopt_set_maxtime)"),
    "a file in core by a reference": ("#include <cstdio>\nauto& opener = std::fopen;\nvoid* f() { return opener(\"x\", \"r\"); }\n", "a file (fopen)"),
    "a file's status by std::filesystem":
        ("#include <filesystem>\nnamespace fs = std::filesystem;\nbool f(const fs::path& p) { return fs::exists(p); }\n", "a file (_ZNSt10filesystem"),
    "the environment by a declaration of its own": ('extern "C" char* getenv(const char*);\nchar* f() { return getenv("A"); }\n', "the environment (getenv)"),
    "a socket": ("#include <sys/socket.h>\nint f() { return socket(1, 2, 0); }\n", "a socket or a device (socket)"),
    "LCM outside procs/bus":
        ('extern "C" int lcm_publish(void*, const char*, const void*, unsigned);\nint f(void* l) { return lcm_publish(l, "A", l, 1); }\n',
         "LCM (lcm_publish)"),
    "a count that a function keeps": ("int f() {\n  static int calls = 0;\n  return ++calls;\n}\n", "state that outlives its call (firn::f()::calls)"),
    "a cache that a function keeps":
        ("#include <vector>\nint f(int n) {\n  static std::vector<int> seen;\n  seen.push_back(n);\n  return int(seen.size());\n}\n",
         "state that outlives its call (firn::f(int)::seen)"),
    "a variable of the file": ("namespace {\nint total = 0;\n}\nint f(int n) { return total += n; }\n", "state that outlives its call"),
    "a variable of the thread": ("thread_local int mine = 0;\nint f() { return ++mine; }\n", "state that outlives its call"),
}

LOOPS = {
    "an alias in a header": ("using Table = std::unordered_map<int, int>;\n", "int f(const Table& t) { int s = 0; for (auto& x : t) s += x.second; return s; }"),
    "a typedef and an iterator": ("typedef std::unordered_map<int, int> Table;\n", "int f(const Table& t) { return t.begin()->second; }"),
    "auto of a function's result":
        ("std::unordered_map<int, int> table();\n", "int f() { int s = 0; const auto t = table(); for (auto x : t) s += x.first; return s; }"),
    "a template that loops over anything":
        ("template <class T>\nint sum(const T& t) { int s = 0; for (auto& x : t) s += x.second; return s; }\n",
         "int f(const std::unordered_map<int, int>& t) { return sum(t); }"),
    "an algorithm of std::ranges":
        ("using Table = std::unordered_map<int, int>;\n", "void f(Table& t) { std::ranges::for_each(t, [](auto& x) { ++x.second; }); }"),
    "std::begin of a member": ("struct Owner { std::unordered_map<int, int> cells; };\n", "int f(Owner& o) { return std::begin(o.cells)->second; }"),
}

TESTS = {
    "a return before the assertion": ('TEST_CASE("a") { if (std::getenv("X")) return; CHECK(f()); }', "may return before its first assertion"),
    "a return behind a condition's assertion": ('TEST_CASE("a") { if (f()) CHECK(g()); return; }', "may return before its first assertion"),
    "no assertion": ('TEST_CASE("a") { const int n = f(); use(n); }', "without an assertion"),
    "an assertion that only a lambda has, called behind a return":
        ('TEST_CASE("a") { const auto check = [&] { CHECK(f()); }; if (g()) return; check(); }', "may return before its first assertion"),
    "a helper that asserts nothing": ('void check_all(int n) { use(n); }\nTEST_CASE("a") { check_all(1); }', "without an assertion"),
    "success and no more": ('TEST_CASE("a") { f(); SUCCEED(); }', "without an assertion"),
    "CHECK(true) through a macro": ('#define GOOD true\nTEST_CASE("a") { CHECK(GOOD); }', "holds by itself (GOOD)"),
    "a macro that checks true": ('#define HOLDS(x) CHECK(x)\nTEST_CASE("a") { HOLDS(1 == 1); }', "holds by itself (1 == 1)"),
    "CHECK of a constant": ('constexpr bool kYes = true;\nTEST_CASE("a") { CHECK(kYes); }', "holds by itself (kYes)"),
    "a name that Catch takes for an option": ('TEST_CASE("--set is taken") { CHECK(f()); }', "begins with '-'"),
    "CHECK of anything or true": ('TEST_CASE("a") { CHECK((f() || true)); }', "holds by itself"),
    "CHECK of a variable with itself": ('TEST_CASE("a") { const int n = f(); CHECK(n == n); }', "holds by itself (n == n)"),
}

FINE_TESTS = {
    "skipped and reported":
        'bool skipped() { skip("models", "none"); return true; }\nTEST_CASE("a") { if (skipped()) return; CHECK(f()); }',
    "skipped at once": 'TEST_CASE("a") { if (!f()) { skip("cbc", "no cbc"); return; } CHECK(g()); }',
    "a return after the assertion": 'TEST_CASE("a") { REQUIRE(f()); if (g()) return; CHECK(h()); }',
    "a return of a lambda": 'TEST_CASE("a") { const auto two = [](int n) { return 2 * n; }; CHECK(two(1) == f()); }',
    "a helper that asserts through another":
        'void one(int n) { CHECK(n == f()); }\nvoid all(int n) { for (int k = 0; k < n; ++k) one(k); }\nTEST_CASE("a") { all(3); }',
    "failing in a branch": 'TEST_CASE("a") { if (f()) FAIL("f"); SUCCEED(); }',
}

TEXTS = {
    "std::shuffle through using": ("#include <algorithm>\nusing std::shuffle;\nvoid f() { shuffle(a, b, g); }\n", "shuffle"),
    "a name for std": ("namespace s = std;\ns::uint64_t n;\n", "a name for std"),
    "all of std": ("using namespace std;\n", "a name for std"),
    "an engine of <random>": ("template <class E = std::minstd_rand>\nvoid f(E e);\n", "randomness"),
    "the processor's counter": ("auto f() { return __builtin_ia32_rdtsc(); }\n", "a clock"),
}


class Tree(SmallTree):
    GOOD = GOOD


class Links(SmallTree):
    def problems(self, links, *objects):
        """Of objects of one name each: (library, what it calls, what it defines)."""
        self.write("links.txt", links)
        found = {}
        for number, (library, calls, defines) in enumerate(objects):
            found[str(number)] = check_symbols.Object(str(number), library, "")
            found[str(number)].calls, found[str(number)].strong = set(calls), set(defines)
        return check_links.check(found, check_links.linked(self.root))

    def test_a_library_that_calls_another_without_a_link_is_found(self):
        found = self.problems("firn_a firn_b\nfirn_b\nfirn_c\n", ("firn_a", ["c"], []), ("firn_c", [], ["c"]))
        self.assertEqual(found, ["firn_a: calls c of firn_c, which it is not linked with"])

    def test_a_link_through_another_library_is_one(self):
        self.assertEqual(self.problems("firn_a firn_b\nfirn_b firn_c\nfirn_c\n", ("firn_a", ["c"], []), ("firn_c", [], ["c"])), [])

    def test_a_name_that_two_libraries_define_is_the_programs_to_choose(self):
        self.assertEqual(self.problems("firn_a\nfirn_b\nfirn_c\n", ("firn_a", ["c"], []), ("firn_b", [], ["c"]), ("firn_c", [], ["c"])), [])


class Symbols(Tree):
    def setUp(self):
        super().setUp()
        self.build = self.root / "build"
        self.build.mkdir()
        self.sources = [path for path in GOOD if path.endswith(".cpp") and not path.startswith("tests/")]
        for path in self.sources:
            self.compile(path)

    def compile(self, path):
        command = ["c++", "-std=c++20", "-O2", "-fno-math-errno", f"-I{self.root}", "-c", str(self.root / path), "-o", path.replace("/", ".") + ".o"]
        subprocess.run(command, cwd=self.build, check=True)

    def problems(self):
        entries = [{"directory": str(self.build), "file": str(self.root / path), "command": f"c++ -c {path} -o {path.replace('/', '.')}.o"}
                   for path in self.sources]
        (self.build / "compile_commands.json").write_text(json.dumps(entries))
        objects, missing = check_symbols.objects_of(self.build, self.root)
        came_from = check_symbols.linked_into_nodes(objects)
        return missing + check_symbols.check_calls(objects, came_from)[0] + check_symbols.check_state(objects, came_from, self.root)

    def plant(self, path, text):
        before = GOOD[path]
        head = "".join(line + "\n" for line in text.split("\n") if line.startswith("#include"))
        body = "".join(line + "\n" for line in text.split("\n") if not line.startswith("#include"))
        self.write(path, head + before + "namespace firn {\n" + body + "}  // namespace firn\n")
        self.compile(path)
        found = self.problems()
        self.write(path, before)
        return found

    def test_the_good_tree_passes(self):
        self.assertEqual(self.problems(), [])

    def test_each_planted_symbol_is_found_by_name(self):
        for what, (text, wanted) in SYMBOLS.items():
            with self.subTest(what):
                found = self.plant("core/control/mpc.cpp", text)
                self.assertTrue(found and all(p.startswith("core/control/mpc.cpp: ") for p in found), found)
                self.assertTrue(any(wanted in p for p in found), found)

    def test_what_a_node_reaches_through_another_room_is_found_with_its_way(self):
        found = self.plant("core/control/mpc.cpp", "long stamp();\nlong f() { return stamp(); }\n")
        self.assertEqual(found, ["files/log.cpp: calls a clock (time); linked into a node: "
                                 "files/log.cpp <- core/control/mpc.cpp <- procs/stage/node.cpp"])

    def test_an_allowance_for_rooms_apart_ends_where_a_node_is_linked_with_them(self):
        path = "core/statistics/distributions.cpp"
        self.write(path, "#include <cmath>\nnamespace firn {\ndouble tail(double x) { return std::log(x); }\n}  // namespace firn\n")
        self.sources.append(path)
        self.compile(path)
        self.assertEqual(self.problems(), [])
        found = self.plant("procs/stage/node.cpp", "double tail(double);\ndouble f(double x) { return tail(x); }\n")
        self.assertEqual(len(found), 1, found)
        self.assertIn("core/statistics/distributions.cpp <- procs/stage/node.cpp", found[0])

    def batch(self, paths):
        """Compiles these sources as one, as CMake's unity build does, and returns the problems."""
        batch = self.build / "Unity" / "unity_0_cxx.cxx"
        batch.parent.mkdir(parents=True)
        batch.write_text("".join(f'#include "{self.root}/{path}"\n' for path in paths))
        self.sources = [path for path in self.sources if path not in paths] + ["build/Unity/unity_0_cxx.cxx"]
        subprocess.run(["c++", "-std=c++20", "-O2", "-fno-math-errno", f"-I{self.root}", "-c", str(batch), "-o",
                        "build.Unity.unity_0_cxx.cxx.o"], cwd=self.build, check=True)
        return self.problems()

    def test_a_symbol_in_a_batch_is_found_with_its_sources(self):
        path = "core/control/mpc.cpp"
        self.write(path, GOOD[path] + "#include <ctime>\nlong f() { return time(nullptr); }\n")
        found = self.batch(["core/grid/grid.cpp", path])
        self.assertEqual(found, ["core/grid/grid.cpp core/control/mpc.cpp: calls a clock (time); linked into a node: "
                                 "core/grid/grid.cpp core/control/mpc.cpp <- procs/stage/node.cpp"])

    def test_what_one_source_may_call_a_batch_with_others_may_not(self):
        paths = ["core/statistics/distributions.cpp", "core/statistics/other.cpp"]
        self.write(paths[0], "#include <cmath>\nnamespace firn {\ndouble tail(double x) { return std::log(x); }\n}  // namespace firn\n")
        self.write(paths[1], "namespace firn {\nint other() { return 1; }\n}  // namespace firn\n")
        found = self.batch(paths)
        self.assertEqual(len(found), 1, found)
        self.assertIn(" ".join(paths) + ": calls an inexact function", found[0])

    def test_a_source_without_its_object_is_named(self):
        (self.build / "core.grid.grid.cpp.o").unlink()
        self.assertEqual(self.problems(), ["core/grid/grid.cpp"])

    def test_constants_that_are_worked_out_once_are_no_state(self):
        self.assertEqual(self.plant("core/control/mpc.cpp", "#include <string>\n#include <vector>\nconst std::string& f(int n) {\n"
                                    "  static const std::vector<std::string> kNames{std::to_string(n), std::string(99, 'x')};\n"
                                    "  return kNames[1];\n}\n"), [])


class Syntax(Tree):
    def test_the_good_tree_passes(self):
        self.assertEqual(check_ast.check(self.root, self.root / "build"), [])

    def test_lookups_pass(self):
        self.write("core/grid/grid.cpp", "#include <unordered_map>\nnamespace firn {\nusing Table = std::unordered_map<int, int>;\n"
                   "int f(const Table& t) {\n  const auto at = t.find(3);\n  return at == t.end() ? int(t.size()) : at->second;\n}\n}\n")
        self.assertEqual(check_ast.check(self.root, self.root / "build"), [])

    def test_each_planted_loop_is_found_where_it_is(self):
        for what, (header, source) in LOOPS.items():
            with self.subTest(what):
                self.write("files/table.h", f"#pragma once\n#include <unordered_map>\nnamespace firn {{\n{header}}}  // namespace firn\n")
                self.write("core/grid/grid.cpp", '#include "files/table.h"\n#include <algorithm>\nnamespace firn {\n' + source + "\n}  // namespace firn\n")
                found = check_ast.check(self.root, self.root / "build")
                if "template" in what:  # in the header: in which room it is does not matter to a node
                    self.write("core/grid/table.h", (self.root / "files/table.h").read_text())
                    self.write("core/grid/grid.cpp", (self.root / "core/grid/grid.cpp").read_text().replace("files/", "core/grid/"))
                    found = check_ast.check(self.root, self.root / "build")
                    self.assertEqual(found, ["core/grid/table.h:5: iterates over an unordered container"])
                else:
                    self.assertEqual(found, ["core/grid/grid.cpp:4: iterates over an unordered container"])

    def test_a_source_that_clang_cannot_parse_is_named(self):
        self.write("core/grid/grid.cpp", "#include <unordered_map>\nnamespace firn { int f() { return g(); } }\n")
        self.assertIn("core/grid/grid.cpp: clang cannot parse it", check_ast.check(self.root, self.root / "build")[0])


class Names(Tree):
    def setUp(self):
        super().setUp()
        self.write(".clang-tidy", (Path(__file__).resolve().parents[2] / ".clang-tidy").read_text())
        command = f"c++ -I{self.root} -c grid.cpp -o core/grid.cpp.o"
        self.write("build/compile_commands.json", json.dumps([{"directory": str(self.root / "build"), "file": "grid.cpp", "command": command}]))

    def problems(self, *sources):
        return check_names.check(self.root, self.root / "build", sources)

    def test_the_good_tree_passes(self):
        self.assertEqual(self.problems("core/grid/grid.cpp"), [])

    def test_a_name_against_the_rules_and_a_warning_of_clang_are_found_in_headers_and_in_sources(self):
        self.write("core/grid/grid.h", "#pragma once\nnamespace firn {\nint Cells(int n);\nclass Grid {\n  int unused_ = 0;\n};\n}  // namespace firn\n")
        self.write("core/grid/other.cpp", "int twice(int Number) { return 2 * Number; }\n")
        found = self.problems()
        self.assertEqual([p.split(" [")[0] for p in found], ["core/grid/grid.h:3: invalid case style for function 'Cells'",
                                                             "core/grid/grid.h:5: private field 'unused_' is not used"])
        self.assertEqual(self.problems("core/grid/other.cpp")[:2], found[:2])
        self.assertIn("core/grid/other.cpp:1: invalid case style for parameter 'Number' [readability-identifier-naming]",
                      self.problems("core/grid/other.cpp"))

    def test_a_source_that_clang_cannot_parse_is_a_problem(self):
        self.write("core/grid/grid.cpp", "int f() { return g(); }\n")
        self.assertIn("core/grid/grid.cpp:1: use of undeclared identifier 'g' [clang-diagnostic-error]", self.problems("core/grid/grid.cpp"))


class Structure(Tree):
    def test_the_good_tree_passes(self):
        self.assertEqual(check_tests.check(self.root), [])

    def test_each_planted_test_is_found(self):
        for what, (text, wanted) in TESTS.items():
            with self.subTest(what):
                self.write("tests/core/grid_test.cpp", GOOD["tests/core/grid_test.cpp"] + text + "\n")
                found = check_tests.check(self.root)
                self.assertEqual(len(found), 1, found)
                self.assertIn(wanted, found[0])
                self.assertTrue(found[0].startswith("tests/core/grid_test.cpp:"), found)

    def test_sound_tests_pass(self):
        for what, text in FINE_TESTS.items():
            with self.subTest(what):
                self.write("tests/core/grid_test.cpp", text + "\n")
                self.assertEqual(check_tests.check(self.root), [])


class Text(Tree):
    def test_each_planted_text_is_found(self):
        self.assertEqual(check_house.check_same_bytes(self.root), [])
        for what, (text, wanted) in TEXTS.items():
            with self.subTest(what):
                self.write("core/grid/grid.cpp", GOOD["core/grid/grid.cpp"] + text)
                found = check_house.check_same_bytes(self.root)
                self.assertTrue(found and all(p.startswith("core/grid/grid.cpp:") for p in found), found)
                self.assertTrue(any(wanted in p for p in found), found)


if __name__ == "__main__":
    unittest.main()
