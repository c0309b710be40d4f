#include "tests/live/live_checks.h"

#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/grid/random.h"
#include "plant/record/record.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "replay/audit_run.h"
#include "replay/replayer.h"
#include "runs/folder/log_repair.h"
#include "runtime/wal_file.h"
#include "tests/support/skip.h"

namespace firn::test {
namespace {

/// The world's records carry node time; `run` has one clock per incarnation, and the last one counts here.
constexpr std::int64_t kSafeWithinNs = 1'000'000'000;

/// Returns a sentence for each violation, so that a check's expansion tells them.
std::string violations_of(const replay::AuditVerdict& audit) {
  std::string all;
  for (const replay::Violation& v : audit.violations)
    all += std::string(replay::word(v.kind)) + ": " + v.what + "\n";
  return all;
}

}  // namespace

bool skipped() {
  if (multicast_refused().empty()) return false;
  skip("multicast", multicast_refused());
  return true;
}

void check_safe_after(const LiveRun& run, std::int64_t mono_ns) {
  const std::int64_t limit_us = run.node_time_us(mono_ns + kSafeWithinNs);
  const plant::WorldHistory world = plant::read_history(run.folder().world_record_path());
  std::int64_t last_shot_us = 0, open_since_us = -1;
  for (const auto& shot : world.shots)
    if (shot.outcome == plant::ShotOutcome::kFired) last_shot_us = std::max(last_shot_us, shot.t_us);
  for (const auto& lamp : world.lamp) {
    open_since_us = lamp.event == plant::LampEvent::kOpened ? lamp.t_us : -1;
    if (open_since_us < 0) CHECK(lamp.t_us <= limit_us);
  }
  CHECK(last_shot_us <= limit_us);
  CHECK(open_since_us == -1);
  for (const auto& list : world.firings) {
    CHECK(list.last_us <= limit_us);
    if (run.lines) CHECK((list.end_us > 0 && list.end_us <= limit_us));
  }
  std::int64_t moves_since_us = -1;
  for (const auto& d : world.devices) switch (d.event) {
      case plant::DeviceEvent::kRobotMotion:
        moves_since_us = d.t_us;
        break;
      case plant::DeviceEvent::kRobotRest:
      case plant::DeviceEvent::kRobotBraked:
      case plant::DeviceEvent::kRobotWatchdog:
      case plant::DeviceEvent::kRobotError:
        moves_since_us = -1;
        CHECK(d.t_us <= limit_us);
        break;
      default:
        break;
    }
  CHECK(moves_since_us == -1);
}

double unsafe_for_s(const LiveRun& run, std::int64_t mono_ns) {
  const std::int64_t from_us = run.node_time_us(mono_ns);
  const plant::WorldHistory world = plant::read_history(run.folder().world_record_path());
  std::int64_t last_us = from_us;
  for (const auto& shot : world.shots)
    if (shot.outcome == plant::ShotOutcome::kFired) last_us = std::max(last_us, shot.t_us);
  for (const auto& lamp : world.lamp) last_us = std::max(last_us, lamp.t_us);
  return double(last_us - from_us) * 1e-6;
}

int status_of(LiveRun& run) {
  const bool started = run.wait_started();
  INFO(run.path() << "\n" << run.said());
  REQUIRE(started);
  const int status = run.wait_finished();
  UNSCOPED_INFO(run.said());
  return status;
}

std::filesystem::path programs_with(const std::filesystem::path& folder, const std::string& name,
                                    const std::string& script) {
  const std::filesystem::path real = FIRN_BINARY_DIR "/bin";
  std::filesystem::create_directory(folder);
  for (const auto& entry : std::filesystem::directory_iterator(real))
    if (entry.path().filename() != name)
      std::filesystem::create_symlink(entry.path(), folder / entry.path().filename());
  std::ofstream(folder / name) << "#!/bin/sh\n" << script << "\n";
  std::filesystem::permissions(folder / name, std::filesystem::perms::owner_all);
  return folder;
}

std::string starts(const std::string& name, const std::string& before) {
  return before + "\nexec " FIRN_BINARY_DIR "/bin/" + name + " \"$@\"";
}

void kill_and_resume(const Experiment& experiment, const std::string& victim, const std::string& witness,
                     std::uint64_t seed, std::uint64_t earliest_us, std::uint64_t latest_us) {
  RandomStream random(seed, Purpose::kKill);
  LiveRun run(experiment);
  run.start(false);
  INFO(victim << ", seed " << seed << ", " << run.path());
  REQUIRE(run.wait_started());
  ::usleep(useconds_t(earliest_us + random.below(latest_us - earliest_us)));
  REQUIRE(run.running());
  const std::int64_t at = run.kill(victim);
  const int status = run.wait();
  run.wait_all_gone();
  INFO(run.said());
  CHECK(status == (victim == "launcher" ? -1 : 3));
  CHECK_FALSE(run.folder().result());
  if (victim != "world") check_safe_after(run, at);  // with the world its instruments are gone
  if (victim != "launcher")
    CHECK_THAT(run.said(), Catch::Contains(victim + " was killed by signal 9"));
  else
    CHECK(local_stop_cause(run, witness) == "the launcher is gone");

  run.start(true);
  const int resumed = run.wait_finished();
  INFO(run.said());
  CHECK(resumed == 0);
  check_finished_run(run);
}

void check_finished_run(const LiveRun& run) {
  std::vector<replay::NodeMaker> makers;
  for (const NamedMaker& m : taking_part(full_product(), run.path()))
    makers.push_back({info(m.id).name, m.make});
  replay::ReplayOptions options;
  options.makers = makers;
  const replay::RunVerdict verdict = replay::replay_run(run.path(), options);
  for (const auto& f : verdict.findings)
    UNSCOPED_INFO(f.node << " step " << f.step.value_or(0) << " " << f.channel << " " << f.field << ": "
                         << f.what);
  for (const auto& d : verdict.damage) UNSCOPED_INFO(d.file << " byte " << d.offset << ": " << d.reason);
  CHECK(verdict.identical());
  CHECK(verdict.nodes.size() == makers.size());
  CHECK(verdict.log_present);
  CHECK(verdict.log_messages > 0);
  CHECK_FALSE(runs::repair_from_write_ahead(run.path() / "log.lcm", run.path() / "nodes")
                  .rewritten);  // it is whole already
  const replay::AuditVerdict audit = replay::audit_run(run.path());
  CHECK(violations_of(audit) == "");
  CHECK(audit.with_world);
  for (const auto& doubt : audit.unknowns) CHECK(doubt.resolved_by);
}

std::string local_stop_cause(const LiveRun& run, const std::string& node) {
  const record::MappedFile mapped(run.folder().wal_path(node));
  record::RecordReader reader(mapped.bytes());
  std::string cause;
  while (const auto record = reader.next()) {
    if (record->damaged || record->kind != std::uint16_t(WalKind::kEvent)) continue;
    const Event e = decode_event(record->payload).event;
    if (e.kind == EventKind::kLocalStop)
      cause.assign(reinterpret_cast<const char*>(e.bytes.data()), e.bytes.size());
  }
  return cause;
}

}  // namespace firn::test
