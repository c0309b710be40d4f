#include <sys/resource.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <clocale>
#include <cmath>
#include <thread>

#include "core/control/prediction.h"
#include "core/control/rim_inset.h"
#include "files/text_file.h"
#include "print/inputs/python_input.h"
#include "python/host/load.h"
#include "tests/docs/level_controller.h"
#include "tests/python/level_prints.h"
#include "tests/support/temp_folder.h"

namespace firn {
namespace {

using control::Decision;
using test::python_input;

constexpr auto kAsIs = [](auto decide) { decide(); };

control::Setup small_setup() {
  const GridSpec grid{6, 5, 0.25, 0.25, 0.0, 0.0};
  control::Setup s{grid, HeightMap(grid, 0.04), Mask(grid, 1), {0.0044, 0.0006, 0.0002}};
  s.mask.at(0, 0) = 0;
  s.seed = 7;
  return s;
}

struct Files {
  Files(std::string text, std::string helper = "") {
    blobs.push_back(python_input("mine.py", text));
    if (!helper.empty()) blobs.push_back(python_input("helper.py", helper));
  }
  std::unique_ptr<control::LayerController> make(const std::string& name = "Mine") const {
    control::ControlOptions options;
    options.scheme = "python:mine.py:" + name;
    return make_python_controller(small_setup(), options, blobs);
  }
  Decision decide(int layer = 0, int attempt = 0) const {
    const HeightMap height(small_setup().grid, 0.0);
    return make()->decide({height, layer, attempt, 0.0});
  }
  Blobs blobs;
};

// A class whose decide has this body; `s` is its setup.
std::string mine(const std::string& body, const std::string& head = "") {
  return "import numpy as np\nfrom firn import Print, End, Stop\n" + head +
         "class Mine:\n def __init__(self, setup, **more): self.s = setup; self.more = more\n"
         " def decide(self, m):\n  s = self.s\n  " +
         body + "\n";
}

TEST_CASE("a level controller in Python decides the droplets of the same controller in C++, layer by layer") {
  const control::Setup setup = test::cylinder_setup();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    control::LevelController cpp(setup, {});
    const auto python = test::python_level(setup);
    const auto a = test::decisions(cpp, setup, seed, kAsIs), b = test::decisions(*python, setup, seed, kAsIs);
    REQUIRE(a.size() == b.size());
    CHECK(a.size() >= 53);
    for (std::size_t n = 0; n < a.size(); ++n) {
      REQUIRE(a[n].kind == b[n].kind);
      REQUIRE(a[n].drops == b[n].drops);
      REQUIRE(a[n].objective_mm == b[n].objective_mm);
      REQUIRE(a[n].objective_none_mm == b[n].objective_none_mm);
    }
  }
}

TEST_CASE("a controller in Python is given setup, measurement, prediction and arguments") {
  const Files files(mine(R"(assert s.shape == (5, 6) and s.target_mm.shape == s.mask.shape == (5, 6)
  assert not s.mask[0, 0] and s.mask.sum() == 29 and s.mask.dtype == bool
  assert (s.target_mm == 0.04).all() and s.pitch_x_mm == 0.25 and s.seed == 7 and s.h1_mm == 0.0044
  assert m.height_mm.shape == (5, 6) and m.layer == 3 and m.attempt == 1 and m.noise_std_mm == 0.001
  assert m.height_mm[2, 1] == 0.5 and m.height_mm[0, 0] == 0.0
  assert self.more == {"gain": 0.5, "rows": [1, 2], "name": "x"}
  for array in (m.height_mm, s.target_mm, s.mask):
    try: array[0, 0] = 1; assert False
    except ValueError: pass
  one = np.zeros(s.shape, int); one[2, 3] = 2
  after = s.predict(np.zeros(s.shape), one)
  assert abs(after.sum() - 2 * s.layer_height_mm) < 1e-15 and after[2, 3] > after[2, 2] > after[1, 2] > 0
  assert abs(s.objective_mm(np.zeros(s.shape)) - 0.04) < 1e-15
  return Print(one, "one")  )"));
  HeightMap height(small_setup().grid, 0.0);
  height.at(1, 2) = 0.5;
  height.at(0, 0) = kNotMeasured;
  const Decision d = files.make("Mine(gain=0.5, rows=[1, 2], name='x')")->decide({height, 3, 1, 0.001});
  CHECK(d.kind == Decision::Kind::kPrint);
  CHECK(d.drops.at(3, 2) == 2);
  CHECK(d.drops.total() == 2);
  CHECK(d.reason == "one");
  CHECK(d.objective_mm < d.objective_none_mm);
}

// A setup whose droplets may land at the places of `options`.
control::Setup placed_setup(const OffsetOptions& options) {
  control::Setup s = small_setup();
  s.mask.at(1, 0) = s.mask.at(2, 2) = 0;
  const OffsetTable table(options);
  s.offsets.table = table;
  s.offsets.kernels.clear();
  for (int n = 0; n < table.size(); ++n)
    s.offsets.kernels.push_back(deposition::mixed_kernel(s.model, table[n]));
  return s;
}

std::unique_ptr<control::LayerController> made_on(const control::Setup& setup, const Files& files,
                                                  const std::string& name = "Mine") {
  control::ControlOptions options;
  options.scheme = "python:mine.py:" + name;
  return make_python_controller(setup, options, files.blobs);
}

TEST_CASE("a controller in Python chooses places of droplets, which its prediction and its decision have") {
  const control::Setup setup = placed_setup({OffsetKind::kGrid, 3, 3});
  const Files files(mine(R"(assert s.places.shape == (9, 2) and (s.places[0] == 0).all()
  assert (s.nearest_place(s.places[:, 0], s.places[:, 1]) == np.arange(9)).all()
  drops = np.zeros(s.shape, int); drops[2, 3] = 1
  at = np.full(s.shape, s.nearest_place(-1 / 3, 1 / 3))
  flat = np.zeros(s.shape)
  after = s.predict(flat, drops, at)
  assert after[2, 2] > after[2, 4] and after[3, 3] > after[1, 3]
  assert (s.predict(flat, drops) == s.predict(flat, drops, np.zeros(s.shape, int))).all()
  return Print(drops, "one", at)  )"));
  const HeightMap flat(setup.grid, 0.0);
  const Decision d = made_on(setup, files)->decide({flat, 0, 0, 0.0});
  CHECK(d.reason == "one");
  REQUIRE(d.offsets.size() == setup.grid.size());
  const int place = setup.offsets.table.nearest({-1.0 / 3, 1.0 / 3});
  for (std::size_t c = 0; c < d.offsets.size(); ++c)
    CHECK(d.offsets.of(c) == (d.drops.cells[c] ? place : 0));  // a cell without a droplet has none
  control::Predictor predict(setup);
  CHECK(d.objective_mm ==
        control::objective_mm(predict.after(flat, d.drops, {}, d.offsets), setup.target, setup.mask, 1.0));
}

TEST_CASE("places that a controller in Python cannot have are refused by cell and limit") {
  const auto said = [](const std::string& places, OffsetKind kind) {
    const control::Setup setup = placed_setup({kind, 3, 3});
    const Files files(mine("return Print(s.mask, '', " + places + ")"));
    try {
      made_on(setup, files)->decide({HeightMap(setup.grid, 0.0), 0, 0, 0.0});
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(said("np.ones(s.shape, int)", OffsetKind::kX).empty());
  CHECK_THAT(said("np.full(s.shape, 9)", OffsetKind::kX),
             Catch::Contains("places: cell (2, 0) has 9") && Catch::Contains("rows 0 to 2"));
  CHECK_THAT(said("np.full(s.shape, -1)", OffsetKind::kX), Catch::Contains("has -1"));
  CHECK_THAT(said("np.ones(s.shape, int)", OffsetKind::kNone), Catch::Contains("actuation.offsets"));
  CHECK_THAT(said("np.ones((2, 2), int)", OffsetKind::kX), Catch::Contains("(2, 2)"));
  CHECK_THAT(said("np.ones(s.shape)", OffsetKind::kX), Catch::Contains("float64"));
  CHECK(said("np.zeros(s.shape, int)", OffsetKind::kNone).empty());
}

TEST_CASE("the shipped controller in Python aims the rim's droplets where control.rim_inset does") {
  const std::string text = read_file(FIRN_SOURCE_DIR "/experiments/python/inset.py");
  for (const OffsetOptions& options :
       {OffsetOptions{OffsetKind::kX, 4, 4}, OffsetOptions{OffsetKind::kGrid, 4, 4}}) {
    const control::Setup setup = placed_setup(options);
    const Decision d =
        made_on(setup, Files(text), "Inset(inset=0.3)")->decide({HeightMap(setup.grid, 0.0), 0, 0, 0.0});
    REQUIRE(d.kind == Decision::Kind::kPrint);
    const OffsetMap wanted = control::inset_places(setup, 0.3);
    for (std::size_t c = 0; c < setup.grid.size(); ++c)
      if (d.drops.cells[c]) CHECK(d.offsets.of(c) == wanted.of(c));
  }
}

TEST_CASE("End and Stop of a controller in Python have no droplet") {
  const Decision end = Files(mine("return End('finished')")).decide();
  CHECK(end.kind == Decision::Kind::kEnd);
  CHECK(end.drops.total() == 0);
  CHECK(end.drops.size() == small_setup().grid.size());
  CHECK(end.reason == "finished");
  CHECK(end.objective_mm == end.objective_none_mm);
  CHECK(Files(mine("return Stop('help')")).decide().kind == Decision::Kind::kStop);
}

TEST_CASE("a reason that no message can hold is mended, in an answer and in an exception") {
  CHECK(Files(mine("return Stop('a\\0b\\ud800c')")).decide().reason == "a?b?c");
  CHECK_THROWS_WITH(Files(mine("raise ValueError('a\\0b\\ud800c')")).decide(), Catch::Contains("a?b?c"));
  CHECK(Files(mine("return Stop('x' * 5000)")).decide().reason.size() == 1000);
}

TEST_CASE("a controller in Python that wants more than max_layers stops for the operator") {
  control::ControlOptions options;
  options.scheme = "python:mine.py:Mine";
  options.max_layers = 4;
  const Files files(mine("return Print(s.mask)"));
  const auto scheme = make_python_controller(small_setup(), options, files.blobs);
  const HeightMap height(small_setup().grid, 0.0);
  CHECK(scheme->decide({height, 3, 0, 0.0}).kind == Decision::Kind::kPrint);
  CHECK(scheme->decide({height, 4, 0, 0.0}).kind == Decision::Kind::kStop);
}

TEST_CASE("an exception in a controller in Python is named with the traceback of its files") {
  const Files files(mine("import helper\n  return helper.worse(m)"),
                    "def worse(m):\n    return 1 / (m.layer - 2)\n");
  CHECK_THROWS_WITH(files.decide(2), Catch::Contains("ZeroDivisionError") &&
                                         Catch::Contains("\"helper.py\", line 2, in worse") &&
                                         Catch::Contains("\"mine.py\", line 8, in decide") &&
                                         Catch::Contains("return 1 / (m.layer - 2)") &&
                                         !Catch::Contains("contract.py"));
  for (const char* body : {"raise SystemExit(0)", "raise KeyboardInterrupt", "exit()", "def f(): f()\n  f()"})
    CHECK_THROWS_AS(Files(mine(body)).decide(), std::runtime_error);
  CHECK_THROWS_WITH(Files(mine("pass", "1 / 0\n")).make(), Catch::Contains("\"mine.py\", line 3"));
  CHECK_THROWS_WITH(Files("class Mine:\n def decide(self, m): pass\n").make(), Catch::Contains("TypeError"));
}

TEST_CASE("an answer that is no decision is refused by its fault") {
  const auto refused = [](const char* body, const char* part) {
    INFO(body);
    CHECK_THROWS_WITH(Files(mine(body)).decide(), Catch::Contains(part));
  };
  refused("pass", "returned NoneType");
  refused("return s.mask", "returned ndarray");
  refused("return Print(np.ones((6, 5), int))", "shape (6, 5); the grid's is (5, 6)");
  refused("return Print(np.ones(s.shape))", "float64");
  refused("return Print(np.ones(s.shape, int))", "cell (0, 0) is off the part");
  refused("return Print(16 * s.mask.astype(int))", "0 to 15 per layer");
  refused("return Print(-1 * s.mask.astype(int))", "0 to 15 per layer");
  refused("return Print(0 * s.mask)", "Print of no droplet");
  refused("return Print(s.predict(m.height_mm[1:], s.mask) > 0)", "heights of shape (4, 6)");
  refused("return Print(s.predict(m.height_mm / 0, s.mask) > 0)", "not finite");
}

TEST_CASE("a class that is not there, or no controller, is refused by its name") {
  const Files files(mine("pass", "class Other:\n def decide(self, m): pass\nnumber = 1\n"));
  CHECK_THROWS_WITH(files.make("Nine"), Catch::Contains("no class Nine") && Catch::Contains("Other, Mine"));
  CHECK_THROWS_WITH(files.make("number"), Catch::Contains("no class number"));
  CHECK_THROWS_WITH(Files("class Mine: pass\n").make(), Catch::Contains("no method decide"));
  CHECK_THROWS_WITH(files.make("Mine(1)"), Catch::Contains("NAME=VALUE"));
  CHECK_THROWS_WITH(files.make("Mine(a=print)"), Catch::Contains("NAME=VALUE"));
  CHECK_THROWS_WITH(files.make("Mine(a=1) or f("), Catch::Contains("must read"));
  control::ControlOptions options;
  options.scheme = "python:other.py:Mine";
  CHECK_THROWS_WITH(make_python_controller(small_setup(), options, files.blobs),
                    Catch::Contains("other.py is no input of this run"));
}

TEST_CASE("a clock, threads, files, processes and unseeded randomness are named at the moment of their use") {
  const auto refused = [](const char* body, const char* part, const char* head = "") {
    INFO(body);
    CHECK_THROWS_WITH(Files(mine(body, head)).decide(), Catch::Contains(part));
  };
  refused("return Print(s.mask)", "import time: reads a clock", "import time\n");
  refused("__import__('datetime').datetime.now()", "import datetime: reads a clock");
  refused("import random", "import random: draws numbers");
  refused("import threading", "import threading: starts threads");
  refused("import os", "import os: reaches files");
  refused("import importlib", "import importlib");
  refused("open('/etc/passwd')", "open: reaches files");
  refused("np.load('/etc/passwd')", "open /etc/passwd: reaches files");
  refused("np.random.rand()", "numpy.random.rand: draws numbers");
  refused("np.random.default_rng()", "numpy.random.default_rng: draws numbers");
  refused("np.random.default_rng(None)", "numpy.random.default_rng: draws numbers");
  refused("np.random.PCG64()", "draws numbers");
  refused("np.random.seed(1)", "numpy.random.seed: draws numbers");
  refused("id(s)", "id: an address differs");
}

// The annotations of both classes are looked up in the module's names: ClassVar and Rates.
const std::string kDataClasses =
    "from __future__ import annotations\nimport typing\nfrom typing import ClassVar\n"
    "from dataclasses import dataclass, field, fields\nfrom firn import Stop\n"
    "@dataclass\nclass Rates:\n rise: float = 0.5\n names: ClassVar[int] = 3\n"
    "@dataclass\nclass Gains:\n rates: Rates = field(default_factory=Rates)\n list: list = "
    "field(default_factory=list)\n"
    "class Mine:\n def __init__(self, setup): self.gains = Gains()\n"
    " def decide(self, m):\n"
    "  assert [f.name for f in fields(Rates)] == ['rise']\n"
    "  assert typing.get_type_hints(Gains)['rates'] is Rates\n"
    "  @dataclass\n  class Late:\n   x: Gains\n"
    "  return Stop(f'{self.gains.rates.rise} {Late.__module__}')\n";

TEST_CASE("dataclasses with annotations as text are made, and find the names of their own file") {
  CHECK(Files(kDataClasses).decide().reason == "0.5 mine");
  std::vector<std::string> reasons(4);
  std::vector<std::thread> threads;
  for (std::string& reason : reasons)
    threads.emplace_back([&] {
      for (int n = 0; n < 20; ++n) reason = Files(kDataClasses).decide().reason;
    });
  for (std::thread& t : threads) t.join();
  CHECK(reasons == std::vector<std::string>(4, "0.5 mine"));
}

TEST_CASE("a module of files is seen by nobody else, and one of a library's name hides no library") {
  Files files(
      mine("import statistics, sys\n  from decimal import Decimal\n  assert 'mine' in sys.modules\n"
           "  return Stop(statistics.word + ' ' + statistics.__name__)"));
  files.blobs.push_back(python_input("statistics.py", "word = 'mine'\n"));
  CHECK(files.decide().reason == "mine statistics_py");
  CHECK(Files("import sys\nfrom firn import Stop\nclass Mine:\n def __init__(self, s): pass\n"
              " def decide(self, m): return Stop(str('helper' in sys.modules))\n")
            .decide()
            .reason == "False");
}

TEST_CASE("a recursion without end stops at once, whatever limit the file asks for") {
  CHECK_THROWS_WITH(Files(mine("sys.setrecursionlimit(10**9)", "import sys\n")).decide(),
                    Catch::Contains("sys.setrecursionlimit(1000000000): calls may be 3000 deep"));
  CHECK_THROWS_WITH(Files(mine("sys.setrecursionlimit(3000)\n  f(0)",
                               "import sys\ndef f(n): return sorted([0], key=lambda _: f(n + 1))\n"))
                        .decide(),
                    Catch::Contains("RecursionError"));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // their allocators end the process
TEST_CASE("more memory than half of the machine's is an error of the call, and the limit ends with it") {
  rlimit before{}, after{};
  REQUIRE(getrlimit(RLIMIT_AS, &before) == 0);
  CHECK_THROWS_WITH(Files(mine("a = bytearray(1 << 45)")).decide(),
                    Catch::Contains("MemoryError") && Catch::Contains("half of the machine's memory"));
  const long pages = ::sysconf(_SC_PHYS_PAGES), page = ::sysconf(_SC_PAGESIZE);
  const std::string most = std::to_string(std::int64_t(0.6 * double(pages) * double(page)));
  CHECK_THROWS_WITH(Files(mine("numpy.empty(" + most + ", dtype=numpy.uint8)", "import numpy\n")).decide(),
                    Catch::Contains("MemoryError"));  // never touched: without the limit it is granted
  REQUIRE(getrlimit(RLIMIT_AS, &after) == 0);
  CHECK(after.rlim_cur == before.rlim_cur);
  CHECK(Files(mine("return Print(s.mask)")).decide().kind == Decision::Kind::kPrint);
}
#endif

TEST_CASE("no controller in Python changes how the program writes numbers") {
  const std::string head = "import locale\n";
  CHECK(Files(mine("locale.setlocale(locale.LC_ALL, ''); return Stop(locale.str(0.5))", head))
            .decide()
            .reason == "0.5");
  CHECK_THROWS_WITH(Files(mine("locale.setlocale(locale.LC_ALL, 'de_DE.UTF-8')", head)).decide(),
                    Catch::Contains("locale.setlocale: would change how numbers are written"));
  CHECK(std::string(std::setlocale(LC_ALL, nullptr)) == "C");
  REQUIRE(std::setlocale(LC_ALL, "C.UTF-8"));  // as a library may, on its way in
  Files(mine("return Print(s.mask)")).decide();
  CHECK(std::string(std::setlocale(LC_ALL, nullptr)) == "C");
}

TEST_CASE(
    "a source file is read as Python reads it: with a byte order mark, or in the encoding that it names") {
  const test::TempFolder folder;
  const auto text_of = [&](const std::string& bytes) {
    write_file_atomically(folder.path() / "mine.py", bytes);
    return python::host().sources((folder.path() / "mine.py").string()).at(0).text;
  };
  CHECK(text_of("\xef\xbb\xbfx = 1\n") == "x = 1\n");
  CHECK(text_of("x = '\xc3\xa9'\n") == "x = '\xc3\xa9'\n");
  CHECK(text_of("# -*- coding: latin-1 -*-\nx = '\xe9'\n") == "# -*- coding: latin-1 -*-\nx = '\xc3\xa9'\n");
  CHECK(text_of("#!/usr/bin/python3\n# vim: set fileencoding=cp1252 :\nx = '\x80'\n")
            .ends_with("x = '\xe2\x82\xac'\n"));
  for (const auto& [bytes, why] :
       {std::pair<std::string, const char*>{"x = 1\ny = '\xe9'\n", "mine.py:2: byte 11 is not UTF-8"},
        {"x = 1\n\n\ny = '\xe9'\n", "mine.py:4: byte 13 is not UTF-8"},
        {"# coding: martian\n", "unknown encoding"},
        {"\xef\xbb\xbf# coding: latin-1\n", "encoding problem"},
        {std::string("\xff\xfex\0=\0", 6), "is UTF-16; save it as UTF-8"},
        {std::string("x = 1\0\n", 7), "null bytes"}})
    CHECK_THROWS_WITH(text_of(bytes), Catch::Contains(why));
}

TEST_CASE("random numbers of a controller in Python depend on seed, layer and attempt only") {
  const Files files(mine("return Print(s.mask & (s.random(m.layer, m.attempt).random(s.shape) < 0.5))"));
  const Decision a = files.decide(3), b = files.decide(3), c = files.decide(4), d = files.decide(3, 1);
  CHECK(a.drops == b.drops);
  CHECK_FALSE(a.drops == c.drops);
  CHECK_FALSE(a.drops == d.drops);
  CHECK_NOTHROW(Files(mine("np.random.default_rng(5).random(); return Print(s.mask)")).decide());
}

TEST_CASE("two controllers of one file share no state, and one file imported twice is one module") {
  const Files files(mine("import helper\n  helper.calls.append(1)\n  return Stop(str(len(helper.calls)))",
                         "import helper\n"),
                    "calls = []\n");
  const HeightMap height(small_setup().grid, 0.0);
  const auto a = files.make(), b = files.make();
  CHECK(a->decide({height, 0, 0, 0.0}).reason == "1");
  CHECK(a->decide({height, 1, 0, 0.0}).reason == "2");
  CHECK(b->decide({height, 0, 0, 0.0}).reason == "1");
}

TEST_CASE("controllers in Python decide the same on many threads") {
  const control::Setup setup = test::cylinder_setup();
  const auto alone = test::decisions(*test::python_level(setup), setup, 5, kAsIs);
  std::vector<std::vector<Decision>> many(4);
  std::vector<std::thread> threads;
  for (auto& mine_of : many)
    threads.emplace_back([&] { mine_of = test::decisions(*test::python_level(setup), setup, 5, kAsIs); });
  for (std::thread& t : threads) t.join();
  for (const auto& m : many) {
    REQUIRE(m.size() == alone.size());
    for (std::size_t n = 0; n < m.size(); ++n) REQUIRE(m[n].drops == alone[n].drops);
  }
}

TEST_CASE("a decision that takes too long ends by its name, and the next one goes on") {
  const Files files(mine("while m.layer == 0: pass\n  return Print(s.mask)"));
  python::ControllerSetup s;
  const control::Setup setup = small_setup();
  s.grid = setup.grid;
  s.target_mm = setup.target.cells;
  s.mask = setup.mask.cells;
  s.most_drops = 1;
  s.longest_s = 0.3;
  const std::string text(reinterpret_cast<const char*>(files.blobs[0].bytes.data()),
                         files.blobs[0].bytes.size());
  const auto controller = python::host().make_controller({{"mine.py", text}}, {"Mine", ""}, s, nullptr);
  const std::vector<double> height(setup.grid.size(), 0.0);
  CHECK_THROWS_WITH(controller->decide(height, 0, 0, 0.0), Catch::Contains("took longer than 0.3"));
  CHECK(controller->decide(height, 1, 0, 0.0).kind == PlanDecision::kPrint);
}

TEST_CASE("other versions of the interpreter or of a package are named with those of the run") {
  Files(mine("return Print(s.mask)")).decide();
  const std::string now = python::host().versions();
  Blob versions = python_input("", now);
  versions.role = kPythonVersionsRole;
  CHECK(now.starts_with("Python 3."));
  CHECK(python_difference({}).empty());
  CHECK(python_difference({versions}).empty());
  Blob other = python_input("", "Python 3.99.0\nnumpy 1.0\n");
  other.role = kPythonVersionsRole;
  CHECK_THAT(python_difference({other}),
             Catch::StartsWith("Python 3.") && Catch::Contains("the run has Python 3.99.0, numpy 1.0"));
  Blob more = python_input("", now + "torch 1.13.0\n");  // of a world, which no replay runs
  more.role = kPythonVersionsRole;
  CHECK(python_difference({more}).empty());
}

TEST_CASE("use_model reaches a class that has it, and its predictions") {
  const Files files(
      mine("return Stop(repr(self.h1) + ' ' + repr(s.predict(0 * m.height_mm, s.mask).sum()))\n"
           " h1 = 0\n def use_model(self, h1_mm, h2_mm, h3_mm): self.h1 = h1_mm"));
  const HeightMap height(small_setup().grid, 0.0);
  const auto scheme = files.make();
  const std::string before = scheme->decide({height, 0, 0, 0.0}).reason;
  scheme->use_model({0.003, 0.0, 0.0});
  const std::string after = scheme->decide({height, 0, 0, 0.0}).reason;
  CHECK(before.starts_with("0 "));
  CHECK(after.starts_with("0.003 0.087"));
  CHECK_NOTHROW(Files(mine("return Print(s.mask)")).make()->use_model({0.003, 0.0, 0.0}));
}

}  // namespace
}  // namespace firn
