// Shards of a study: whatever makes the prints, in how many pieces, killed or damaged, the result is the
// same.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include "cli/compare_command.h"
#include "cli/study_state.h"
#include "config/study.h"
#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "studies/compare/study_runner.h"
#include "studies/compare/study_shards.h"
#include "tests/files/record/scratch.h"

using namespace firn;
namespace fs = std::filesystem;

namespace {

std::atomic<int> shard_prints{0};

StudyPrint imagined(const Experiment& e, const Blobs&, bool) {
  ++shard_prints;
  const double day = random_uniform({e.plant.seed, Purpose::kTest, 0, 0, 0});
  StudyPrint p{true, "finished", "imagined", {1.0 + day + e.control.smf.kp}, 0.5 * e.control.smf.kp};
  if (e.control.smf.kp > 2.5 && e.plant.seed % 7 == 0) p = {false, "error", "kp too large", {NAN}, 0.0};
  return p;
}

const StudyLab kShardLab{
    {{"rms_um", "um", "RMS", 2}}, {"rms_um"}, [](Experiment& e, std::uint64_t seed) { e.plant.seed = seed; },
    [](const Experiment&) {},     &imagined,  {}};

struct ShardBench {
  explicit ShardBench(const std::string& name) : scratch("shards-" + name) {
    options.study = (scratch / "study.toml").string();
    options.output = (scratch / "out").string();
    options.threads = 1;
    options.json = true;
    std::ofstream(options.study) << "name = \"imagined\"\nseeds = 21\n"
                                    "[[scheme]]\nname = \"low\"\nset = [\"control.smf.kp=1\"]\n"
                                    "[[scheme]]\nname = \"as low\"\nset = [\"control.smf.kp=1\"]\n"
                                    "[[scheme]]\nname = \"too high\"\nset = [\"control.smf.kp=3\"]\n"
                                    "[[part]]\nname = \"a\"\n[[part]]\nname = \"b\"\nset = "
                                    "[\"part.height_mm=0.1\"]\n";
    shard_prints = 0;
  }
  int run(const std::string& shard = "", int most = 0) const {
    CompareOptions o = options;
    o.shard = shard;
    o.most = most;
    return compare(o, kShardLab, nullptr);
  }
  StudyPlan plan() const {
    return plan_study(load_study(options.study), fs::path(options.study).parent_path(), kShardLab,
                      options.study);
  }
  fs::path out() const { return scratch / "out"; }
  std::string results() const {
    return read_file(out() / "runs.csv") + read_file(out() / "summary.json") +
           read_file(out() / "report.html");
  }
  test::Scratch scratch;
  CompareOptions options;
};

constexpr int kUnique = 84;  // prints: two schemes are configured alike

}  // namespace

TEST_CASE("shards of any number give each print once and take alike many of each scheme and part",
          "[shards]") {
  const ShardBench b("dealt");
  const StudyPlan plan = b.plan();
  REQUIRE(cells_of(plan, {}).size() == kUnique);
  for (const int of : {1, 2, 7, 40, 84, 100}) {
    std::set<std::string> seen;
    std::map<std::pair<std::size_t, std::size_t>, std::pair<int, int>> most_and_least;
    for (int number = 1; number <= of; ++number) {
      std::map<std::pair<std::size_t, std::size_t>, int> of_class{
          {{0, 0}, 0}, {{0, 1}, 0}, {{2, 0}, 0}, {{2, 1}, 0}};
      for (const StudyCell* c : cells_of(plan, {number, of})) {
        CHECK(seen.insert(c->digest).second);
        ++of_class[{c->arm, c->part}];
      }
      for (const auto& [key, n] : of_class) {
        auto& [most, least] = most_and_least.try_emplace(key, n, n).first->second;
        most = std::max(most, n);
        least = std::min(least, n);
      }
    }
    CHECK(seen.size() == kUnique);
    for (const auto& [key, range] : most_and_least) CHECK(range.first - range.second <= 1);
  }
}

TEST_CASE("a study in shards gives the bytes of the study in one piece, and nothing is printed twice",
          "[shards]") {
  const ShardBench whole("whole");
  REQUIRE(whole.run() == kOk);
  CHECK(shard_prints == kUnique);
  for (const int of : {2, 5, 40}) {
    const ShardBench b("pieces");
    for (int number = of; number >= 1; --number)
      REQUIRE(b.run(std::to_string(number) + "/" + std::to_string(of)) == kOk);
    CHECK(shard_prints == kUnique);
    CHECK(fs::exists(b.out() / "shards" / ("1-of-" + std::to_string(of) + ".journal")));
    CHECK_FALSE(fs::exists(b.out() / "shards" / ("1-of-" + std::to_string(of) + ".part")));
    REQUIRE(b.run() == kOk);
    CHECK(shard_prints == kUnique);
    CHECK(b.results() == whole.results());
  }
}

TEST_CASE("a shard that was broken off goes on with its own lines, and the merge prints what is missing",
          "[shards]") {
  const ShardBench whole("unbroken");
  REQUIRE(whole.run() == kOk);
  RandomStream random(53, Purpose::kTest);
  for (int n = 0; n < 10; ++n) {
    const ShardBench b("broken");
    REQUIRE(b.run("1/3", 1 + int(random.below(20))) == kOk);
    const int made = shard_prints;
    const fs::path part = b.out() / "shards" / "1-of-3.part";
    REQUIRE(fs::exists(part));
    std::string text = read_file(part);
    text.resize(text.size() - random.below(30));  // as after a kill -9 in mid-write
    std::ofstream(part, std::ios::binary) << text;
    REQUIRE(b.run("1/3") == kOk);
    CHECK(shard_prints - 28 <= 1);  // the torn line's print
    CHECK(shard_prints >= made);
    REQUIRE(b.run("3/3") == kOk);
    REQUIRE(b.run() == kOk);
    CHECK(shard_prints - kUnique <= 1);
    CHECK(b.results() == whole.results());
  }
}

TEST_CASE("a shard's damaged line is counted, costs its print alone and changes no result", "[shards]") {
  const ShardBench whole("undamaged");
  REQUIRE(whole.run() == kOk);
  const ShardBench b("damaged");
  REQUIRE(b.run("1/2") == kOk);
  REQUIRE(b.run("2/2") == kOk);
  const fs::path file = b.out() / "shards" / "2-of-2.journal";
  std::string text = read_file(file);
  text[text.size() / 2] ^= 0x01;
  std::ofstream(file, std::ios::binary) << text;
  const auto state = nlohmann::json::parse([&] {
    StudyJournal journal(b.out() / "results.journal", kShardLab.metrics);
    for (const fs::path& shard : shard_journals(b.out())) journal.take(shard);
    return study_state_json(b.plan(), journal, {});
  }());
  CHECK(state["on_record"] == kUnique - 1);
  CHECK(state["damaged_lines"] == 1);
  CHECK_THAT(state["damage"][0]["file"].get<std::string>(), Catch::EndsWith("2-of-2.journal"));
  CHECK(state["damage"][0]["first"] == 1 + std::ranges::count(text.substr(0, text.size() / 2), '\n'));
  shard_prints = 0;
  REQUIRE(b.run() == kOk);
  CHECK(shard_prints == 1);
  CHECK(b.results() == whole.results());
}

TEST_CASE(
    "kinds of unlike known times are dealt so that no shard takes longer than the rest by more than one of "
    "them",
    "[shards]") {
  class Unlike : public StudyWork {
   public:
    Unlike() {
      kinds = {"a", "b", "c", "d"};
      seconds = {200.0, 60.0, 5.0, 1.0};
      for (std::size_t s = 0; s < 12; ++s)
        for (std::size_t k = 0; k < kinds.size(); ++k) cells.push_back({k, 0, s, std::to_string(97 * s + k)});
    }
    StudyPrint make(const StudyCell&) const override { return {}; }
  };
  const Unlike work;
  for (const int of : {2, 3, 5, 7}) {
    std::set<std::string> seen;
    std::vector<double> load;
    for (int k = 1; k <= of; ++k) {
      load.push_back(0.0);
      for (const StudyCell* c : cells_of(work, {k, of})) {
        CHECK(seen.insert(c->digest).second);
        load.back() += work.seconds[c->arm];
      }
    }
    CHECK(seen.size() == work.cells.size());
    CHECK(std::ranges::max(load) - std::ranges::min(load) <= 200.0);
    CHECK(std::ranges::max(load) <= 266.0 * 12 / of + 200.0);
  }
}

TEST_CASE("a shard has one writer, and so has the merge", "[shards]") {
  const ShardBench b("locked");
  fs::create_directories(b.out() / "shards");
  const StudyJournal at_work(b.out() / "shards" / "1-of-2.part", kShardLab.metrics);
  CHECK_THROWS_WITH(b.run("1/2"), Catch::Contains("1-of-2.part: another firn compare is at work"));
  REQUIRE(b.run("2/2") == kOk);
  const StudyJournal merging(b.out() / "results.journal", kShardLab.metrics);
  CHECK_THROWS_WITH(b.run(), Catch::Contains("results.journal: another firn compare is at work"));
}

TEST_CASE("results of another build never count, and those of another platform only where any is asked for",
          "[shards]") {
  const ShardBench b("origin");
  fs::create_directories(b.out() / "shards");
  const StudyOrigin here = study_origin();
  const StudyPlan plan = b.plan();
  const auto write = [&](const char* name, const StudyOrigin& origin, std::size_t first, std::size_t last) {
    StudyJournal journal(b.out() / "shards" / name, kShardLab.metrics, StudyPlatforms::kThis, origin);
    const auto cells = cells_of(plan, {});
    for (std::size_t n = first; n < last; ++n)
      journal.append(cells[n]->digest, "low", "a", 1, {true, "finished", "elsewhere", {9.0}, 0.5});
  };
  write("1-of-2.journal", {"0123456789abcdef", here.platform}, 0, 10);
  write("2-of-2.journal", {here.build, "0123456789abcdef"}, 10, 30);
  const auto journal = [&](StudyPlatforms platforms) {
    auto all = std::make_unique<StudyJournal>(b.out() / "results.journal", kShardLab.metrics, platforms);
    for (const fs::path& shard : shard_journals(b.out())) all->take(shard);
    return all;
  };
  CHECK(journal(StudyPlatforms::kThis)->size() == 0);
  CHECK(journal(StudyPlatforms::kThis)->of_other_builds() == 10);
  CHECK(journal(StudyPlatforms::kThis)->of_other_platforms() == 20);
  CHECK(journal(StudyPlatforms::kAny)->size() == 20);
  REQUIRE(b.run() == kOk);
  CHECK(shard_prints == kUnique);
  CHECK(read_file(b.out() / "summary.json").find("other platforms") == std::string::npos);
  ShardBench any("any");
  fs::create_directories(any.out() / "shards");
  fs::copy(b.out() / "shards", any.out() / "shards", fs::copy_options::recursive);
  any.options.platform = "any";
  shard_prints = 0;
  REQUIRE(any.run() == kOk);
  CHECK(shard_prints == kUnique - 20);
  CHECK(read_file(any.out() / "summary.json").find("20 results of a platform") != std::string::npos);
}

TEST_CASE(
    "prints that stopped are made again alone, and a study tells hours only of schemes that it has timed",
    "[shards]") {
  ShardBench b("again");
  REQUIRE(b.run("", 1) == kOk);
  CHECK(shard_prints == 1);
  CHECK_FALSE(fs::exists(b.out() / "summary.json"));
  const auto state = [&] {
    const StudyJournal journal(b.out() / "results.journal", kShardLab.metrics);
    return nlohmann::json::parse(study_state_json(b.plan(), journal, {}));
  };
  CHECK(state()["hours"].is_null());
  CHECK(state()["to_do"] == kUnique - 1);
  REQUIRE(b.run() == kOk);
  CHECK(state()["hours"] == 0.0);
  CHECK(state()["failed"] == 6);
  shard_prints = 0;
  b.options.again = true;
  REQUIRE(b.run() == kOk);
  CHECK(shard_prints == 6);
}

TEST_CASE("a study whose --fail-if holds gives exit code 1, and an unknown scheme in it is named",
          "[shards]") {
  ShardBench b("fail-if");
  b.options.fail_if = "too high worse than low";
  CHECK(b.run() == kFailed);
  b.options.fail_if = "low worse than too high";
  CHECK(b.run() == kOk);
  b.options.fail_if = "low worse than as low";
  CHECK(b.run() == kOk);
  b.options.fail_if = "low worse than best";
  CHECK_THROWS_WITH(b.run(), Catch::Contains("no scheme 'best'; there are low, as low, too high"));
  b.options.fail_if = "low < high";
  CHECK_THROWS_WITH(b.run(), Catch::Contains("A worse than B"));
}

TEST_CASE("the prints of a seed are in the seed's lab whatever the scheme and the part, and labs.csv has it",
          "[shards]") {
  ShardBench b("labs");
  std::ofstream(b.options.study, std::ios::app) << "[prior]\n\"plant.drift\" = [0.01, 0.2]\n";
  const StudyPlan plan = b.plan();
  std::map<std::size_t, std::set<double>> drifts;
  for (const StudyCell& cell : plan.cells) drifts[cell.seed].insert(plan.experiment(cell).plant.drift);
  CHECK(drifts.size() == 21);
  std::set<double> all;
  for (const auto& [seed, of_seed] : drifts) {
    CHECK(of_seed.size() == 1);
    all.insert(of_seed.begin(), of_seed.end());
  }
  CHECK(all.size() == 21);
  REQUIRE(b.run() == kOk);
  const std::string csv = read_file(b.out() / "labs.csv");
  CHECK(csv.starts_with("seed,plant.drift\n1,"));
  CHECK(std::ranges::count(csv, '\n') == 22);
}

TEST_CASE("the state of a study is told while another process is at work, and telling it makes no folder",
          "[shards]") {
  ShardBench b("state");
  b.options.status = true;
  CHECK(b.run() == kOk);
  CHECK_FALSE(fs::exists(b.out()));
  b.options.status = false;
  REQUIRE(b.run("", 2) == kOk);
  const StudyJournal held(b.out() / "results.journal", kShardLab.metrics);
  b.options.status = true;
  CHECK(b.run() == kOk);
  CHECK(b.run("1/2") == kOk);
  b.options.status = false;
  CHECK_THROWS_WITH(b.run(), Catch::Contains("at work on this journal"));
}

TEST_CASE("the shards to do are those with a print that is not on record", "[shards]") {
  ShardBench b("to-do");
  REQUIRE(b.run("2/5") == kOk);
  const StudyPlan plan = b.plan();
  StudyJournal journal(kShardLab.metrics);
  take_journals(journal, b.out(), {});
  CHECK(shards_to_do(plan, journal, 5) == std::vector<int>{1, 3, 4, 5});
  for (const int of : {1, 3, 7, 50, kUnique}) {
    std::vector<int> wanted;
    for (int k = 1; k <= of; ++k) {
      StudyRunOptions shard;
      shard.shard = {k, of};
      if (!prints_to_do(plan, journal, shard).empty()) wanted.push_back(k);
    }
    CHECK(shards_to_do(plan, journal, of) == wanted);
  }
}

TEST_CASE("a shard that ends while the results are read is not missed", "[shards]") {
  ShardBench b("ends");
  REQUIRE(b.run("1/2") == kOk);
  const fs::path ended = shard_journals(b.out()).at(0);
  fs::path at_work = ended;
  at_work.replace_extension(".part");
  std::atomic<bool> over = false;
  std::thread shard([&] {
    for (int n = 0; !over; ++n) {
      fs::rename(n % 2 == 0 ? ended : at_work, n % 2 == 0 ? at_work : ended);
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  });
  const StudyPlan plan = b.plan();
  int found = 0;
  for (int n = 0; n < 300; ++n) {
    StudyJournal journal(kShardLab.metrics);
    take_journals(journal, b.out(), {});
    found += shards_to_do(plan, journal, 2) == std::vector<int>{2};
  }
  over = true;
  shard.join();
  CHECK(found == 300);
}

TEST_CASE("a shard's journal that can never be read is refused by its name", "[shards]") {
  const ShardBench b("unreadable");
  fs::create_directories(b.out() / "shards" / "1-of-2.journal");  // a folder in its place
  StudyJournal journal(kShardLab.metrics);
  CHECK_THROWS_WITH(take_journals(journal, b.out(), {}), Catch::Contains("1-of-2.journal"));
}

TEST_CASE("a whole line that holds no result is damage too", "[shards]") {
  const test::Scratch scratch("no-result");
  const fs::path file = scratch / "1-of-2.journal";
  LineJournal(file, "").append(R"({"digest":"none"})");
  StudyJournal journal(kShardLab.metrics);
  journal.take(file);
  CHECK(journal.size() == 0);
  REQUIRE(journal.damage().size() == 1);
  CHECK(journal.damage()[0].file == file);
  CHECK(journal.damage()[0].first == 1);
}

TEST_CASE("a shard that is none is refused with the text", "[shards]") {
  for (const char* text : {"0/4", "5/4", "3", "3/", "/4", "a/b", "1/1000000", "-1/4", "1.5/4", "1/4/2"})
    CHECK_THROWS_WITH(parse_shard(text), Catch::Contains(text));
  CHECK(parse_shard("4/4").number == 4);
  CHECK(parse_shard("1/1").of == 1);
}
