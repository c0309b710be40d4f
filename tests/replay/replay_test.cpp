// Verdicts of replay on runs that are whole.
#include <catch2/catch.hpp>

#include "replay/print_verdict.h"
#include "runtime/write_ahead.h"
#include "tests/replay/damage.h"
#include "tests/replay/live_bytes.h"
#include "tests/replay/tiny_run.h"

namespace firn::test {
namespace {

TEST_CASE("an untouched run replays identical and says how much was compared") {
  const auto run = scratch_folder("identical");
  record_tiny_run(run);
  const auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.exit_status() == 0);
  CHECK(v.nodes.size() == 4);
  CHECK(v.log_messages == 57);
  CHECK(replay::to_text(v).starts_with("identical: 4 nodes, 124 steps, 57 messages ("));
  CHECK(replay::to_json(v).find("\"identical\": true") != std::string::npos);
}

TEST_CASE("one thread and many replay to the same verdict") {
  const auto run = scratch_folder("threads");
  record_tiny_run(run);
  edit_records(run / "nodes" / "controller.wal", [](Records& r) {
    r.pop_back();
    r.pop_back();
  });
  replay::ReplayOptions one, many;
  one.threads = 1;
  many.threads = 8;
  auto a = replay_tiny(run, one), b = replay_tiny(run, many);
  a.wall_ns = b.wall_ns = 0;
  CHECK(replay::to_json(a) == replay::to_json(b));
}

std::size_t bytes_of_replay(int layers) {
  const auto run = scratch_folder("long-" + std::to_string(layers));
  TinyOptions options;
  options.layers = layers;
  record_tiny_run(run, options);
  replay::ReplayOptions alone;
  alone.threads = 1;
  bool identical = false;
  const std::size_t bytes = peak_live_bytes_of([&] { identical = replay_tiny(run, alone).identical(); });
  REQUIRE(identical);
  return bytes;
}

TEST_CASE("the replay of a run that is four times as long holds no more memory") {
  const std::size_t one = bytes_of_replay(600), two = bytes_of_replay(1200), four = bytes_of_replay(2400);
  INFO("600, 1200 and 2400 layers: " << one << ", " << two << " and " << four << " bytes");
  CHECK(double(two) <= 1.05 * double(one));
  CHECK(double(four) <= 1.05 * double(one));
}

TEST_CASE("one node can be replayed without the others' files") {
  const auto run = scratch_folder("one-node");
  record_tiny_run(run);
  for (const char* other : {"scheduler", "surface_mapper", "laser_profiler"})
    std::filesystem::remove(run / "nodes" / (std::string(other) + ".wal"));
  replay::ReplayOptions options;
  options.only_node = "controller";
  const auto v = replay_tiny(run, options);
  INFO(replay::to_text(v));
  CHECK(v.identical());
  CHECK(v.nodes.size() == 1);
  options.only_node = "contoller";
  CHECK_THROWS_WITH(replay_tiny(run, options), Catch::Contains("no node 'contoller'; nodes: scheduler"));
}

TEST_CASE("a run that was resumed twice replays as one") {
  const auto run = scratch_folder("resumed");
  TinyOptions options;
  options.resumes = 2;
  record_tiny_run(run, options);
  const auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.identical());
  for (const auto& n : v.nodes) CHECK(n.incarnations == 3);
}

TEST_CASE("outputs that a kill cut off are counted and are no divergence") {
  const auto run = scratch_folder("cut");
  record_tiny_run(run);
  edit_records(run / "nodes" / "scheduler.wal", [](Records& r) {
    REQUIRE(r.back().kind == std::uint16_t(WalKind::kOutputs));
    r.pop_back();
  });
  const auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.identical());
  CHECK(v.nodes[0].cut == 1);
  CHECK(replay::to_text(v).find("scheduler: outputs of 1 steps were cut off by a kill") != std::string::npos);
}

TEST_CASE("another commit or platform is named before the verdict and is no divergence by itself") {
  const auto run = scratch_folder("provenance");
  record_tiny_run(run);
  replay::ReplayOptions options;
  options.commit = "fff";
  options.platform = "glibc 3";
  const auto v = replay_tiny(run, options);
  CHECK(v.identical());
  CHECK(replay::to_text(v).starts_with(
      "provenance differs: commit: recorded with 0123abc, replayed with fff\n"
      "provenance differs: platform: recorded with test, replayed with glibc 3\n"));
}

TEST_CASE("a run without a log is judged by its write-ahead files alone") {
  const auto run = scratch_folder("no-log");
  TinyOptions options;
  options.log = false;
  record_tiny_run(run, options);
  const auto v = replay_tiny(run);
  CHECK(v.identical());
  CHECK(!v.log_present);
}

TEST_CASE("a folder that is no run is refused by name") {
  CHECK_THROWS_WITH(replay_tiny(scratch_folder("no-run")),
                    Catch::Contains("is no run folder: it has no experiment.toml"));
}

// The objective is the 8 bytes before the message's last ones; its lowest bit is 1e-17 mm or so.
void change_objective(const std::filesystem::path& run) {
  edit_records(run / "nodes" / "controller.wal", [](Records& r) {
    auto& payload = r[find_record(r, std::uint16_t(WalKind::kOutputs), "LAYER_PLAN", 2)].payload;
    // behind objective_mm: objective_none_mm, iterations, the empty reason with its length and end, drops
    flip(payload, payload.size() - std::size_t(kTinyColumns * kTinyRows) - 5 - 8 - 8 - 1);
  });
}

TEST_CASE("the tolerance lets numbers differ a little, and the largest difference is told") {
  const auto run = scratch_folder("tolerance");
  record_tiny_run(run);
  std::filesystem::remove(run / "log.lcm");
  change_objective(run);
  CHECK(replay_tiny(run).exit_status() == 1);
  replay::ReplayOptions options;
  options.tolerance = 1e-12;
  auto v = replay_tiny(run, options);
  INFO(replay::to_text(v));
  CHECK(v.identical());
  CHECK(v.largest_difference > 0);
  CHECK(v.largest_difference < 1e-12);
  CHECK(v.largest_difference_field.find("LAYER_PLAN.objective_mm") != std::string::npos);
  options.tolerance = 1e-22;
  CHECK(replay_tiny(run, options).exit_status() == 1);
}

TEST_CASE("an ignored field may differ, and the reason is told") {
  const auto run = scratch_folder("ignore");
  record_tiny_run(run);
  std::filesystem::remove(run / "log.lcm");
  change_objective(run);
  for (const char* text :
       {"LAYER_PLAN.objective_mm=the solver was changed", "objective_mm=the solver was changed"}) {
    replay::ReplayOptions options;
    options.ignores = {replay::parse_ignore(text)};
    const auto v = replay_tiny(run, options);
    INFO(replay::to_text(v));
    CHECK(v.identical());
    CHECK(replay::to_text(v).find("(the solver was changed), ") != std::string::npos);
    CHECK(v.ignored.at(0).times >= 1);
  }
  replay::ReplayOptions other;
  other.ignores = {replay::parse_ignore("HEIGHT_MAP.objective_mm=another channel")};
  CHECK(replay_tiny(run, other).exit_status() == 1);
  CHECK_THROWS_WITH(replay::parse_ignore("objective_mm"), Catch::Contains("the reason must be given"));
  CHECK_THROWS_WITH(replay::parse_ignore("objective_mm="), Catch::Contains("the reason must be given"));
}

}  // namespace
}  // namespace firn::test
