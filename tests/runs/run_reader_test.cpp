#include <catch2/catch.hpp>

#include <fstream>

#include "core/grid/random.h"
#include "files/text_file.h"
#include "page/watched_run.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/pack.h"
#include "runs/folder/seal_check.h"
#include "runs/read/run_reader.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

using namespace firn;
using namespace firn::page;
namespace fs = std::filesystem;

namespace {

fs::path printed(const fs::path& root) {
  const Experiment e = test::tiny_print("page");
  const runs::RunFolder run = runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  o.note = [](const std::string&) {};
  REQUIRE(run_in_lab(full_product(), run, o).result.status == 0);
  return run.path();
}

std::set<std::string, std::less<>> wanted() {
  return {"LAYER_METRICS", "LAYER_PLAN", "HEIGHT_MAP", "RUN_END", "STATE_STAGE", "ANSWER_JET"};
}

using Got = std::map<std::string, std::vector<std::vector<std::byte>>>;

runs::RunReader::Sink into(Got& got) {
  return [&got](std::string_view channel, std::span<const std::byte> m, runs::Place) {
    got[std::string(channel)].emplace_back(m.begin(), m.end());
  };
}

}  // namespace

TEST_CASE("the messages of a run are those that replay finds, in the order of time") {
  const test::TempFolder place;
  const fs::path run = printed(place.path());
  Got got;
  std::int64_t last = 0;
  runs::RunReader tail(run, wanted());
  tail.poll([&](std::string_view channel, std::span<const std::byte> m, runs::Place at) {
    const auto stamp = runs::stamp_of(m);
    REQUIRE(stamp);
    CHECK(stamp->utime_us >= last);
    last = stamp->utime_us;
    got[std::string(channel)].emplace_back(m.begin(), m.end());
    CHECK(std::ranges::equal(tail.read(at), m));
  });
  const runs::RunReader oracle(run);
  for (const std::string& channel : wanted()) {
    INFO(channel);
    const auto& all = oracle.on(channel);
    REQUIRE(got[channel].size() == all.size());
    CHECK(std::ranges::equal(got[channel], all,
                             [](const auto& a, const auto& b) { return std::ranges::equal(a, b); }));
  }
  CHECK_FALSE(tail.poll([](auto...) { FAIL("nothing has come"); }));
}

TEST_CASE("a reader that follows growing files hands over the messages that a reader after the end does") {
  const test::TempFolder place;
  const fs::path run = printed(place.path());
  std::size_t complete = 0, lost = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    RandomStream random(seed, Purpose::kTest);
    const fs::path ended = place.path() / ("ended" + std::to_string(seed)),
                   growing = place.path() / ("growing" + std::to_string(seed));
    fs::create_directories(ended / "nodes");
    fs::create_directories(growing / "nodes");
    struct Growing {
      std::string content;
      std::size_t done = 0, begins = 0;  // bytes written; round in which the file appears
    };
    std::map<fs::path, Growing> files;
    for (const fs::path& from : RunPaths(run).wal_files()) {
      Growing file{read_file(from), 0, std::size_t(random.below(5))};
      for (std::uint64_t harmed = seed % 3 == 0 ? 0 : random.below(4); harmed > 0; --harmed)
        file.content[16 + random.below(file.content.size() - 16)] ^= char(1 << random.below(8));
      std::ofstream(ended / "nodes" / from.filename(), std::ios::binary) << file.content;
      files[growing / "nodes" / from.filename()] = std::move(file);
    }
    Got whole, got;
    runs::RunReader(ended, wanted()).poll(into(whole));
    runs::RunReader reader(growing, wanted());
    bool more = true;
    for (std::size_t round = 0; more; ++round) {
      more = false;
      for (auto& [path, file] : files) {
        if (round >= file.begins) {
          const std::size_t n = std::min<std::size_t>(file.content.size() - file.done,
                                                      random.below(file.content.size() / 4 + 64));
          std::ofstream(path, std::ios::binary | std::ios::app) << file.content.substr(file.done, n);
          file.done += n;
        }
        more = more || file.done < file.content.size();
      }
      reader.poll(into(got));
    }
    CHECK(got == whole);
    std::size_t messages = 0;
    for (const auto& [channel, all] : whole) messages += all.size();
    if (seed == 3) complete = messages;
    lost += complete > messages ? complete - messages : 0;
  }
  CHECK(complete > 20);
  CHECK(lost > 0);
}

TEST_CASE("a run that is packed meanwhile stays readable at the same places") {
  const test::TempFolder place;
  const fs::path run = printed(place.path());
  std::optional<runs::Place> map;
  std::vector<std::byte> bytes;
  runs::RunReader tail(run, {"HEIGHT_MAP"});
  tail.poll([&](std::string_view, std::span<const std::byte> m, runs::Place at) {
    map = at;
    bytes.assign(m.begin(), m.end());
  });
  REQUIRE(map);
  runs::pack_run(run);
  tail.poll([](auto...) { FAIL("packing adds no message"); });
  CHECK(tail.read(*map) == bytes);
}

TEST_CASE("rows that came since, over the map of before, are the map of now") {
  const test::TempFolder place;
  const fs::path run = printed(place.path()), growing = place.path() / "growing";
  fs::copy(run, growing, fs::copy_options::recursive);
  const std::string profiles = read_file(run / "nodes" / "laser_profiler.wal");
  for (const char* node : {"laser_profiler", "surface_mapper"})
    fs::remove(growing / "nodes" / (std::string(node) + ".wal"));
  fs::remove(growing / "log.lcm");  // which would be read instead
  WatchedRun watched(full_product(), growing, 0.0);
  std::vector<std::byte> before;
  std::uint64_t since = 0;
  int compared = 0;
  RandomStream random(5, Purpose::kTest);
  for (std::size_t done = 0; done < profiles.size();) {
    const std::size_t n = std::min<std::size_t>(profiles.size() - done, random.below(4000));
    std::ofstream(growing / "nodes" / "laser_profiler.wal", std::ios::binary | std::ios::app)
        << profiles.substr(done, n);
    done += n;
    watched.poll(0.0);
    if (watched.rows_stamp() == since) continue;
    const auto now = watched.partial_map(0);
    REQUIRE(now);
    const std::vector<std::byte> rows = watched.partial_map(since).value();
    if (rows.size() != now->size() || std::uint32_t(rows[20]) & kMapRows) {
      const std::size_t row_bytes = 9 * 4;
      REQUIRE((rows.size() - kMapHeaderBytes) % (4 + row_bytes) == 0);
      for (std::size_t from = kMapHeaderBytes; from < rows.size(); from += 4 + row_bytes) {
        const std::size_t row = std::size_t(rows[from]);
        std::copy_n(rows.begin() + std::ptrdiff_t(from + 4), row_bytes,
                    before.begin() + std::ptrdiff_t(kMapHeaderBytes + row * row_bytes));
      }
      CHECK(std::equal(before.begin() + kMapHeaderBytes, before.end(), now->begin() + kMapHeaderBytes,
                       now->end()));
      ++compared;
    }
    before = *now;
    since = watched.rows_stamp();
  }
  CHECK(compared > 3);
}
