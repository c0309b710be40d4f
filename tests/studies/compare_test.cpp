#include "cli/compare_command.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "print/labs/full_product.h"
#include "print/labs/product.h"
#include "runs/folder/run_folder.h"
#include "studies/compare/study_journal.h"
#include "tests/files/record/scratch.h"

using namespace firn;

namespace {

std::atomic<int> prints{0};
std::atomic<bool> stop{false};
std::atomic<int> stop_after{0};

void set_seed(Experiment& e, std::uint64_t seed) { e.plant.seed = seed; }

// A lab whose prints take no time: an RMS of the seed's own plus a term of the gain kp.
StudyPrint imagine(const Experiment& e, const Blobs&, bool) {
  if (++prints == stop_after) stop = true;
  const double day = random_uniform({e.plant.seed, Purpose::kTest, 0, 0, 0}),
               own = random_uniform(
                   {e.plant.seed, Purpose::kTest, 1, 0, std::uint32_t(e.control.smf.kp * 1000)});
  StudyPrint p{true,
               "finished",
               "as \"imagined\"",
               {1.0 + day + 0.1 * own + e.control.smf.kp, 1.0 / 3.0 + day},
               0.001 * double(prints)};
  p.profile = {{1.2, day}, {2.4, day + own}};
  if (e.control.smf.kp > 2.5 && e.plant.seed % 7 == 0) p = {false, "error", "kp too large", {NAN, NAN}, 0.0};
  return p;
}

const StudyLab kLab{{{"rms_um", "um", "RMS", 2}, {"other", "", "other", 3}},
                    {"rms_um", "other"},
                    &set_seed,
                    [](const Experiment&) {},
                    &imagine,
                    {"Along the print", "height_mm", "rms_um"}};

const char* const kStudy = R"(name = "imagined"
seeds = 21
[[scheme]]
name = "low"
set = ["control.smf.kp=1"]
[[scheme]]
name = "high"
set = ["control.smf.kp=2"]
[[scheme]]
name = "too high"
set = ["control.smf.kp=3"]
[[part]]
name = "a"
[[part]]
name = "b"
set = ["part.height_mm=0.1"]
)";

struct Bench {
  explicit Bench(const std::string& name) : scratch("compare-" + name) {
    options.study = (scratch / "study.toml").string();
    options.output = (scratch / "out").string();
    write(kStudy);
    prints = 0;
    stop = false;
    stop_after = 0;
  }
  void write(const std::string& text) { std::ofstream(options.study) << text; }
  int run(int threads = 2) {
    options.threads = threads;
    options.json = true;
    return compare(options, kLab, &stop);
  }
  std::string file(const char* name) const { return read_file(scratch / "out" / name); }
  std::string results() const { return file("runs.csv") + file("summary.json") + file("report.html"); }
  test::Scratch scratch;
  CompareOptions options;
};

}  // namespace

TEST_CASE("a study gives the same bytes for one thread and for several") {
  Bench one("one"), two("two");
  REQUIRE(one.run(1) == kOk);
  CHECK(prints == 126);
  CHECK(one.file("profile.csv").find("\"low\",\"a\",1.2,21,") != std::string::npos);
  REQUIRE(two.run(3) == kOk);
  CHECK(one.results() == two.results());
  CHECK(one.file("summary.json").find("low is better") != std::string::npos);
  CHECK(one.file("summary.json").find("too high: 6 of 42 prints stopped") != std::string::npos);
}

TEST_CASE("an interrupted study goes on where it stopped, to the same result") {
  Bench whole("whole");
  REQUIRE(whole.run() == kOk);
  for (const int after : {1, 40, 125}) {
    Bench b("broken");
    stop_after = after;
    REQUIRE(b.run(after == 125 ? 1 : 2) == kInterrupted);  // a second thread might make the last print
    CHECK(!std::filesystem::exists(b.scratch / "out" / "summary.json"));
    const int made = prints;
    CHECK(made < 126);
    stop = false;
    stop_after = 0;
    prints = 0;
    REQUIRE(b.run() == kOk);
    CHECK(prints == 126 - made);
    CHECK(b.results() == whole.results());
    prints = 0;
    REQUIRE(b.run() == kOk);
    CHECK(prints == 0);
  }
}

TEST_CASE("a record torn or damaged anywhere costs the prints of those lines and nothing else") {
  Bench whole("undamaged");
  REQUIRE(whole.run() == kOk);
  const std::string record = whole.file("results.journal");
  RandomStream random(5, Purpose::kTest);
  for (int n = 0; n < 12; ++n) {
    Bench b("torn");
    std::filesystem::create_directories(b.scratch / "out");
    std::string text = record;
    if (n % 2 == 0)
      text.resize(random.below(std::uint32_t(text.size())));
    else
      text[random.below(std::uint32_t(text.size()))] ^= 0x10;
    std::ofstream(b.scratch / "out" / "results.journal", std::ios::binary) << text;
    REQUIRE(b.run() == kOk);
    CHECK(b.results() == whole.results());
    if (n % 2 == 1) CHECK(prints <= 2);  // a flipped newline joins two lines
    prints = 0;
    REQUIRE(b.run() == kOk);
    CHECK(prints == 0);
  }
}

TEST_CASE("a changed study makes what is new and keeps what still holds") {
  Bench b("changed");
  REQUIRE(b.run() == kOk);
  prints = 0;
  std::string text = kStudy;
  text.replace(text.find("kp=2"), 4, "kp=2.2");
  b.write(text);
  REQUIRE(b.run() == kOk);
  CHECK(prints == 42);
  prints = 0;
  text.replace(text.find("seeds = 21"), 10, "seeds = 25");
  b.write(text);
  REQUIRE(b.run() == kOk);
  CHECK(prints == 3 * 2 * 4);
  b.write(kStudy);  // and back: all is on record
  prints = 0;
  REQUIRE(b.run() == kOk);
  CHECK(prints == 0);
}

TEST_CASE("schemes that are configured alike are printed once and are not distinguishable") {
  Bench b("alike");
  b.write("name = \"null\"\nseeds = 15\n[[scheme]]\nname = \"one\"\n[[scheme]]\nname = \"other\"\n");
  REQUIRE(b.run() == kOk);
  CHECK(prints == 15);
  CHECK(b.file("summary.json").find("one and other are not distinguishable in rms_um") != std::string::npos);
}

TEST_CASE("two studies cannot write one folder at the same time") {
  const test::Scratch scratch("compare-lock");
  const StudyJournal first(scratch / "results.journal", kLab.metrics);
  CHECK_THROWS_WITH(StudyJournal(scratch / "results.journal", kLab.metrics),
                    Catch::Contains("another firn compare"));
}

TEST_CASE("an unknown metric is answered with the known ones and the nearest") {
  Bench b("metric");
  b.write(std::string("metrics = [\"rmsum\"]\n") + kStudy);
  CHECK_THROWS_WITH(b.run(), Catch::Contains("rmsum") && Catch::Contains("rms_um, other") &&
                                 Catch::Contains("nearest is rms_um"));
}

TEST_CASE("the ink-jet lab: a real study on two threads, a null pair, and the same bytes on one") {
  const char* text = R"(name = "small"
seeds = 3
metrics = ["rms_um", "droplets"]
set = ["grid.nx=14", "grid.ny=14", "part.diameter_mm=2.6", "part.height_mm=0.03", "part.shape=cylinder"]
[[scheme]]
name = "mpc"
[[scheme]]
name = "mpc again"
set = ["control.threshold.threshold_mm=0.001"]
[[scheme]]
name = "bounded"
set = ["control.max_layers=2"]
[[scheme]]
name = "threshold"
set = ["control.scheme=threshold"]
)";
  std::string results[2];
  for (int n = 0; n < 2; ++n) {
    Bench b("inkjet");
    b.write(text);
    b.options.threads = n + 1;
    REQUIRE(compare(b.options, inkjet_study_lab(), nullptr) == kOk);
    results[n] = b.results();
    const std::string csv = b.file("runs.csv");
    CHECK(csv.find("\"bounded\",\"part\",1,0,\"waits for operator\"") != std::string::npos);
    // A setting of another scheme changes nothing: pair for pair the same print.
    for (int seed = 1; seed <= 3; ++seed) {
      const auto line = [&](const std::string& arm) {
        const std::size_t at = csv.find("\"" + arm + "\",\"part\"," + std::to_string(seed));
        return csv.substr(at + arm.size() + 2, csv.find('\n', at) - at - arm.size() - 2);
      };
      CHECK(line("mpc") == line("mpc again"));
    }
  }
  CHECK(results[0] == results[1]);
}

TEST_CASE("A scheme that is given its number of layers is judged by the study's part like any other") {
  Experiment e;
  const double tolerance_um = tolerance_of_part_um(e);
  CHECK(tolerance_um > 0.0);
  e.control.scheme = "open_loop";
  e.control.open_loop.layers = 1;
  e.part.shape.height_mm = 0.1;
  CHECK(tolerance_of_part_um(e) == tolerance_um);
  const StudyPrint p = inkjet_study_lab().print(e, make_inputs(full_product(), e, "."), false);
  CHECK(p.outcome == "finished");
  CHECK(p.within == std::optional(false));
  e.control.scheme = "pattern";
  CHECK(tolerance_of_part_um(e) == 0.0);
}
