// Runs whole prints of a small ice part in process, and checks the conditions that must hold after any of
// them. The including test includes Catch.
#pragma once

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "cli/replay_command.h"
#include "config/include.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/robot_command_t.hpp"
#include "firn/safe_stop_t.hpp"
#include "plant/record/record.h"
#include "plant/world/ice_lab.h"
#include "plant/world/setup.h"
#include "plant/world/world.h"
#include "print/inputs/ice_inputs.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "runs/read/run_reader.h"
#include "tests/files/record/scratch.h"

namespace firn::test {

struct SmallIce {
  Experiment experiment;
  Blobs inputs;
};

inline SmallIce small_ice_part(const std::vector<std::string>& overrides) {
  const std::filesystem::path folder = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";
  SmallIce s{load_experiment(folder / "ice-small.toml", overrides), {}};
  s.inputs = make_inputs(full_product(), s.experiment, folder);
  place_ice_field(s.experiment, s.inputs);
  return s;
}

inline void check_replay(const std::filesystem::path& run) {
  ReplayCommandOptions r;
  r.run = run.string();
  const replay::RunVerdict verdict = replay_verdict(full_product(), r);
  INFO(replay::to_text(verdict));
  CHECK(verdict.identical());
}

inline replay::AuditVerdict check_audit(const std::filesystem::path& run) {
  const replay::AuditVerdict audit = replay::audit_run(run);
  INFO(replay::to_text(audit));
  CHECK(audit.clean());
  return audit;
}

/// One print of the small part, incarnation by incarnation.
class IceRun {
 public:
  explicit IceRun(const std::vector<std::string>& overrides = {})
      : scratch_("ice-run-" + std::to_string(++made())),
        small_(small_ice_part(overrides)),
        folder_(runs::RunFolder::create(scratch_ / "runs", small_.experiment, small_.inputs, {"test"})) {}

  /// @param faults as of --fault; a resume goes on in node time where the print stopped
  /// @param orders of the operator, by node time
  LabRunReport go(const std::vector<std::string>& faults = {}, bool resume = false,
                  std::vector<LabOrder> orders = {}) {
    LabRunOptions o;
    o.resume = resume;
    o.later = std::move(orders);
    o.nature = nature;
    o.faults = parse_lab_faults(faults, small_.experiment);
    return run_in_lab(full_product(), folder_, o);
  }
  std::filesystem::path path() const { return folder_.path(); }
  std::filesystem::path world_record() const { return folder_.world_record_path(); }

  /// The texts of all FAULT messages.
  std::string faults() const {
    std::string all;
    const runs::RunReader messages(path());
    for (const NodeInfo& n : nodes())
      messages.each<fault_t>(channels::fault(n.id).name,
                             [&](const fault_t& f) { all += f.node + ": " + f.text + "\n"; });
    return all;
  }

  /// Checks the world's record: after the first stop only pulses already on their way are fired, and the arm
  /// rests.
  void check_safe(double within_s = 0.1) const {
    const runs::RunReader messages(path());
    std::int64_t stop_us = -1;
    messages.each<safe_stop_t>(channels::kSafeStop.name, [&](const safe_stop_t& s) {
      if (stop_us < 0) stop_us = s.header.utime_us;
    });
    const plant::WorldHistory world = plant::read_history(world_record());
    if (stop_us >= 0)
      for (const plant::FiringRecord& f : world.firings)
        CHECK(f.last_us <= stop_us + std::int64_t(within_s * 1e6));
    check_rest(world);
    CHECK_FALSE(world_at_end().ice()->nature().arm().commanded());
  }

  /// The world as it was when the print ended.
  plant::World world_at_end() const {
    plant::WorldConfig config = plant::world_config(small_.experiment);
    if (nature) nature(config);
    return plant::World::restore(path() / "world" / "state", config, nullptr);
  }

  static void check_rest(const plant::WorldHistory& world) {
    bool moving = false;
    for (const plant::DeviceRecord& d : world.devices) switch (d.event) {
        case plant::DeviceEvent::kRobotMotion:
          moving = true;
          break;
        case plant::DeviceEvent::kRobotRest:
        case plant::DeviceEvent::kRobotBraked:
        case plant::DeviceEvent::kRobotWatchdog:
        case plant::DeviceEvent::kRobotError:
          moving = false;
          break;
        default:
          break;
      }
    CHECK_FALSE(moving);
  }

  /// RUN commands of the first incarnation, in order.
  std::vector<robot_command_t> runs(int signals) const {
    std::vector<robot_command_t> all;
    runs::RunReader(path()).each<robot_command_t>(
        channels::kRobotCommand.name, [&](const robot_command_t& c) {
          if (RobotVerb(c.verb) == RobotVerb::kRun && (c.signals & signals) != 0) all.push_back(c);
        });
    return all;
  }

  std::function<void(plant::WorldConfig&)> nature;  ///< as LabRunOptions'

 private:
  static int& made() {
    static int n = 0;
    return n;
  }

  Scratch scratch_;
  SmallIce small_;
  runs::RunFolder folder_;
};

}  // namespace firn::test
