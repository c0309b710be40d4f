// Replay must be able to fail: each change of a recorded run gives exit 1 (or 2 for unreadable files) and
// names node, step, channel, field and both values.
#include <catch2/catch.hpp>

#include <fstream>

#include "config/experiment.h"
#include "core/grid/random.h"
#include "replay/print_verdict.h"
#include "runs/folder/config_change.h"
#include "runtime/write_ahead.h"
#include "tests/replay/damage.h"
#include "tests/replay/tiny_run.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using replay::Finding;
using replay::FindingKind;

constexpr auto kEvent = std::uint16_t(WalKind::kEvent);
constexpr auto kOutputs = std::uint16_t(WalKind::kOutputs);

fs::path recorded(const std::string& name, const TinyOptions& options = {}) {
  const fs::path run = scratch_folder(name);
  record_tiny_run(run, options);
  return run;
}

fs::path wal(const fs::path& run, const std::string& node) { return run / "nodes" / (node + ".wal"); }

// Flips the lowest bit of the last byte of the n-th such record - the last droplet count of a LAYER_PLAN - in
// the file as it stands, so that the checksum no longer holds.
void flip_last_byte(const fs::path& file, std::uint16_t kind, std::string_view channel, int n) {
  const Records records = read_records(file);
  const auto& payload = records[find_record(records, kind, channel, n)].payload;
  auto bytes = read_bytes(file);
  flip(bytes, find_bytes(bytes, payload) + payload.size() - 1);
  write_bytes(file, bytes);
}

void check_plan_finding(const Finding& f, FindingKind kind, const std::string& node, std::int64_t seq) {
  CHECK(f.kind == kind);
  CHECK(f.node == node);
  REQUIRE(f.step);
  CHECK(f.channel == "LAYER_PLAN");
  CHECK(f.seq == seq);
  CHECK(f.field == "drops[23]");
  CHECK(f.recorded != f.replayed);
  CHECK((f.recorded == "0" || f.recorded == "1"));
  CHECK((f.replayed == "0" || f.replayed == "1"));
}

TEST_CASE("a flipped bit in a recorded LAYER_PLAN is named, whether or not the checksum was mended") {
  for (const bool mended : {false, true}) {
    const fs::path run = recorded("flip-output");
    flip_last_byte(wal(run, "controller"), kOutputs, "LAYER_PLAN", 3);
    if (mended) edit_records(wal(run, "controller"), [](Records&) {});
    const auto v = replay_tiny(run);
    INFO(replay::to_text(v));
    CHECK(v.exit_status() == 1);
    CHECK(v.damage.size() == (mended ? 0 : 1));
    check_plan_finding(v.findings.at(0), FindingKind::kOutput, "controller", 4);
    CHECK(v.findings[0].inputs.size() == 4);
    CHECK(v.findings[0].inputs.back().find("HEIGHT_MAP") != std::string::npos);
    CHECK(v.findings_total == 1);  // that scheduler and log hold the true plan is not told again
    CHECK(replay::to_text(v).find("first divergence:\n  controller, step ") != std::string::npos);
  }
}

TEST_CASE("a flipped bit in a delivered LAYER_PLAN is named, whether or not the checksum was mended") {
  for (const bool mended : {false, true}) {
    const fs::path run = recorded("flip-event");
    flip_last_byte(wal(run, "scheduler"), kEvent, "LAYER_PLAN", 3);
    if (mended) edit_records(wal(run, "scheduler"), [](Records&) {});
    const auto v = replay_tiny(run);
    INFO(replay::to_text(v));
    CHECK(v.exit_status() == 1);
    CHECK(v.damage.size() == (mended ? 0 : 1));
    check_plan_finding(v.findings.at(0), FindingKind::kDelivery, "scheduler", 4);
  }
}

TEST_CASE("a flipped bit in log.lcm is named, with and without the index") {
  for (const bool index : {true, false}) {
    const fs::path run = recorded("flip-log");
    if (!index) fs::remove(run / "log.lcm.idx");
    const Records plans = read_records(wal(run, "scheduler"));
    const auto& payload = plans[find_record(plans, kEvent, "LAYER_PLAN", 3)].payload;
    auto bytes = read_bytes(run / "log.lcm");
    const std::vector<std::byte> end(payload.end() - 80, payload.end());
    flip(bytes, find_bytes(bytes, end) + end.size() - 1);
    write_bytes(run / "log.lcm", bytes);
    const auto v = replay_tiny(run);
    INFO(replay::to_text(v));
    CHECK(v.exit_status() == 1);
    CHECK(v.damage.size() == (index ? 1 : 0));
    check_plan_finding(v.findings.at(0), FindingKind::kLog, "controller", 4);
  }
}

TEST_CASE("a message that the log lost is named") {
  const fs::path run = recorded("log-gap");
  edit_records(wal(run, "controller"), [](Records&) {});
  auto bytes = read_bytes(run / "log.lcm");
  bytes.resize(bytes.size() / 2);
  write_bytes(run / "log.lcm", bytes);
  const auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.exit_status() == 1);
  CHECK(replay::to_text(v).find("log.lcm lacks this and ") != std::string::npos);
}

TEST_CASE("a changed gain is told by key, and the first divergence by the plan it changes") {
  for (const bool by_file : {true, false}) {
    const fs::path run = recorded("gain");
    std::vector<std::string> overrides;
    if (by_file) {
      std::ifstream in(run / "experiment.toml");
      std::string text{std::istreambuf_iterator<char>(in), {}};
      const std::size_t at = text.find("kp = 1.0\n");
      REQUIRE(at != std::string::npos);
      std::ofstream(run / "experiment.toml") << text.replace(at, 8, "kp = 0.3");
    } else {
      overrides = {"control.smf.kp=0.3"};
    }
    const auto change = runs::config_change(run, runs::recorded_config(run), overrides);
    REQUIRE(change.settings.size() == 1);
    CHECK(change.settings[0].starts_with("control.smf.kp: recorded 1"));
    replay::ReplayOptions options;
    options.change_config = change.change;
    const auto v = replay_tiny(run, options);
    INFO(replay::to_text(v));
    CHECK(v.exit_status() == 1);
    const Finding& f = v.findings.at(0);
    CHECK(f.node == "controller");
    CHECK(f.channel == "LAYER_PLAN");
    CHECK(f.field.starts_with("drops["));
    CHECK(f.recorded == "1");
    CHECK(f.replayed == "0");
    CHECK(f.step);
    CHECK(!f.inputs.empty());
  }
  const fs::path run = recorded("same-gain");
  CHECK(!runs::config_change(run, runs::recorded_config(run), {"control.smf.kp=1.0"}).change);
}

TEST_CASE("a run of a version without a key is replayed with the default of today, if nothing is changed") {
  const fs::path run = recorded("without-key");
  std::string text = runs::recorded_config(run);
  const std::string key = "stall_layers = ";
  const std::size_t at = text.find(key);
  REQUIRE(at != std::string::npos);
  text.erase(at, text.find('\n', at) + 1 - at);
  std::ofstream(run / "experiment.toml") << text;
  const auto change = runs::config_change(run, text, {});
  CHECK(change.settings.empty());
  REQUIRE(change.change);
  CHECK(change.change(text).find("\n" + key + std::to_string(Experiment{}.control.stall_layers) + "\n") !=
        std::string::npos);
}

struct Removal {
  const char* node;
  const char* text;  // in the event's record
  int n;
};

// The event, with the outputs it led to.
void remove_event(const fs::path& file, const char* text, int n, bool renumber_rest) {
  edit_records(file, [&](Records& r) {
    const std::size_t at = find_record(r, kEvent, text, n);
    const bool with_outputs = at + 1 < r.size() && r[at + 1].kind == kOutputs;
    r.erase(r.begin() + std::ptrdiff_t(at), r.begin() + std::ptrdiff_t(at + 1 + with_outputs));
    if (renumber_rest)
      for (std::size_t k = at; k < r.size(); ++k) renumber(r[k], -1);
  });
}

TEST_CASE("a missing event is named by node and step, even when the rest was numbered anew") {
  for (const Removal& removal :
       {Removal{"surface_mapper", "HEIGHT_PROFILE", 5}, Removal{"controller", "HEIGHT_MAP", 2},
        Removal{"scheduler", "LAYER_PLAN", 1}, Removal{"laser_profiler", "PROFILER_COMMAND", 2},
        Removal{"scheduler", "ANSWER_LASER_PROFILER", 2}})
    for (const bool renumbered : {false, true}) {
      const fs::path run = recorded("missing-event");
      remove_event(wal(run, removal.node), removal.text, removal.n, renumbered);
      const auto v = replay_tiny(run);
      INFO(replay::to_text(v));
      CHECK(v.exit_status() == 1);
      const Finding& f = v.findings.at(0);
      CHECK(f.node == removal.node);
      CHECK(f.kind == FindingKind::kMissing);
      CHECK(f.step);
      const std::string all = replay::to_text(v);
      if (!renumbered) CHECK(all.find("the event of step ") != std::string::npos);
      CHECK(all.find(std::string("the delivery of ") + removal.text + " " + std::to_string(removal.n + 1) +
                     " is missing") != std::string::npos);
    }
}

TEST_CASE("missing instrument bytes and missing wake-ups are found too") {
  for (const EventKind kind : {EventKind::kIo, EventKind::kWake}) {
    const fs::path run = recorded("missing-io");
    const std::string node = kind == EventKind::kIo ? "laser_profiler" : "scheduler";
    edit_records(wal(run, node), [&](Records& r) {
      std::vector<std::size_t> found;
      for (std::size_t k = 0; k < r.size(); ++k)
        if (r[k].kind == kEvent && decode_event(r[k].payload).event.kind == kind) found.push_back(k);
      const std::size_t at = found.at(found.size() / 2);
      const bool with_outputs = r[at + 1].kind == kOutputs;
      r.erase(r.begin() + std::ptrdiff_t(at), r.begin() + std::ptrdiff_t(at + 1 + with_outputs));
      for (std::size_t k = at; k < r.size(); ++k) renumber(r[k], -1);
    });
    const auto v = replay_tiny(run);
    INFO(replay::to_text(v));
    CHECK(v.exit_status() == 1);
    CHECK(v.findings.at(0).node == node);
    CHECK(v.findings.at(0).step);
  }
}

TEST_CASE("events in another order are found") {
  const fs::path run = recorded("reordered");
  edit_records(wal(run, "surface_mapper"), [](Records& r) {
    const std::size_t a = find_record(r, kEvent, "HEIGHT_PROFILE", 4),
                      b = find_record(r, kEvent, "HEIGHT_PROFILE", 5);
    std::swap(r[a], r[b]);
    renumber(r[a], -1);
    renumber(r[b], +1);
  });
  const auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.exit_status() == 1);
  CHECK(v.findings.at(0).node == "surface_mapper");
  CHECK(replay::to_text(v).find("HEIGHT_PROFILE 5 was delivered after 6") != std::string::npos);
}

TEST_CASE("a wake-up that the node did not ask for is named") {
  const fs::path run = recorded("wake");
  edit_records(wal(run, "scheduler"), [](Records& r) {
    for (RawRecord& record : r) {
      if (record.kind != kEvent) continue;
      WalEvent e = decode_event(record.payload);
      if (e.event.kind != EventKind::kWake) continue;
      e.event.due.us += 1;
      std::vector<std::byte> changed;
      encode_event(e.step, e.event, changed);
      record.payload = changed;
      return;
    }
  });
  const auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.findings.at(0).kind == FindingKind::kTimer);
  CHECK(v.findings[0].node == "scheduler");
  CHECK(v.findings[0].channel == "timer 3");
}

TEST_CASE("a file cut anywhere is found") {
  for (const char* node : {"scheduler", "surface_mapper", "controller", "laser_profiler"}) {
    const fs::path run = recorded("truncated");
    const auto whole = read_bytes(wal(run, node));
    RandomStream random(11, Purpose::kTest, std::uint32_t(find_node(node)->id));
    for (int trial = 0; trial < 40; ++trial) {
      auto cut = whole;
      cut.resize(random.below(std::uint32_t(whole.size())));
      write_bytes(wal(run, node), cut);
      const auto v = replay_tiny(run);
      INFO(node << " cut at byte " << cut.size() << " of " << whole.size() << "\n" << replay::to_text(v));
      CHECK(v.exit_status() != 0);
      CHECK(replay::to_text(v).find(node) != std::string::npos);
    }
  }
}

TEST_CASE("a bit flipped anywhere in a write-ahead file is found") {
  const fs::path run = recorded("any-bit");
  RandomStream random(12, Purpose::kTest);
  for (const char* node : {"scheduler", "surface_mapper", "controller", "laser_profiler"}) {
    const auto whole = read_bytes(wal(run, node));
    for (int trial = 0; trial < 100; ++trial) {
      auto bytes = whole;
      const std::size_t at = random.below(std::uint32_t(whole.size()));
      flip(bytes, at, int(random.below(8)));
      write_bytes(wal(run, node), bytes);
      const auto v = replay_tiny(run);
      INFO(node << " byte " << at << "\n" << replay::to_text(v));
      CHECK(v.exit_status() != 0);
      CHECK(replay::to_text(v).find(node) != std::string::npos);
    }
    write_bytes(wal(run, node), whole);
  }
}

TEST_CASE("a file of another run or another node is refused by name") {
  TinyOptions other;
  other.run_id = 78;
  const fs::path run = recorded("foreign"), foreign = recorded("foreign-other", other);
  fs::copy_file(wal(foreign, "controller"), wal(run, "controller"), fs::copy_options::overwrite_existing);
  auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.exit_status() == 1);
  CHECK(v.findings.at(0).node == "controller");
  CHECK(v.findings[0].what == "nodes/controller.wal is a file of run 78, the run is 77");

  const fs::path swapped = recorded("swapped");
  fs::copy_file(wal(swapped, "scheduler"), wal(swapped, "controller"), fs::copy_options::overwrite_existing);
  v = replay_tiny(swapped);
  CHECK(v.exit_status() == 1);
  CHECK(v.findings.at(0).what == "nodes/controller.wal is a file of node scheduler");
}

TEST_CASE("a missing file, input or head is told by name with exit 2") {
  fs::path run = recorded("no-input");
  const fs::path input = fs::directory_iterator(run / "inputs")->path();
  fs::remove(input);
  auto v = replay_tiny(run);
  INFO(replay::to_text(v));
  CHECK(v.exit_status() == 2);
  CHECK(v.findings.at(0).kind == FindingKind::kUnreadable);
  CHECK(v.findings[0].what == "input 'target' is missing: inputs/" + input.filename().string());

  run = recorded("changed-input");
  std::ofstream(fs::directory_iterator(run / "inputs")->path(), std::ios::app) << "x";
  v = replay_tiny(run);
  CHECK(v.exit_status() == 2);
  CHECK(v.findings.at(0).what.starts_with("input 'target' was changed: inputs/"));

  run = recorded("no-file");
  fs::remove(wal(run, "controller"));
  v = replay_tiny(run);
  CHECK(v.exit_status() == 2);
  CHECK(v.findings.at(0).node == "controller");

  run = recorded("no-head");
  edit_records(wal(run, "controller"), [](Records& r) { r.erase(r.begin()); });
  v = replay_tiny(run);
  CHECK(v.exit_status() == 2);
  CHECK(v.findings.at(0).node == "controller");
  CHECK(v.findings[0].what.find("where the head must be") != std::string::npos);
}

}  // namespace
}  // namespace firn::test
