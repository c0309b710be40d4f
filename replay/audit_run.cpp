#include "replay/audit_run.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "config/devices.h"
#include "config/experiment.h"
#include "config/labs.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "lcmtypes/channels.h"
#include "plant/inkjet/model.h"
#include "plant/record/record.h"
#include "replay/path_audit.h"
#include "runs/folder/config_change.h"
#include "runs/folder/host_record.h"
#include "runs/folder/one_run.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/seal_check.h"
#include "runs/folder/truth_check.h"
#include "runs/read/run_reader.h"

namespace firn::replay {
namespace {

Shot::Outcome outcome_of(plant::ShotOutcome outcome) {
  switch (outcome) {
    case plant::ShotOutcome::kFired:
      return Shot::Outcome::kFired;
    case plant::ShotOutcome::kMissed:
      return Shot::Outcome::kMissed;
    default:
      return Shot::Outcome::kIgnored;
  }
}

// world.rec of a run; nothing where there is none (a real lab).
std::optional<WorldTruth> read_world_truth(const std::filesystem::path& run, const Experiment& e) {
  const std::filesystem::path path = RunPaths(run).world_record_path();
  if (!std::filesystem::exists(path)) return {};
  const plant::WorldHistory history = plant::read_history(path);
  WorldTruth truth;
  truth.damaged = history.damaged;
  for (const plant::ShotRecord& s : history.shots) {
    plant::NearestCell cell{s.i, s.j};
    // Position of the second nozzle as the lab believed it: its error belongs to nature, and firn calibrate
    // finds it.
    if (s.nozzle == 1)
      cell = plant::nearest_cell(e.grid, s.x_mm + e.jet_b.offset_x_mm, s.y_mm + e.jet_b.offset_y_mm);
    truth.shots.push_back({s.t_us, cell.i, cell.j, s.exposures, outcome_of(s.outcome),
                           s.nozzle == 1 ? Material::kB : Material::kA, s.x_mm, s.y_mm});
  }
  for (const plant::DeviceRecord& d : history.devices)
    if (d.event == plant::DeviceEvent::kJetArmed || d.event == plant::DeviceEvent::kJetDisarmed)
      truth.jet.push_back({d.t_us, d.event == plant::DeviceEvent::kJetArmed,
                           d.port == plant::Port::kJetB ? Material::kB : Material::kA});
  return truth;
}

// Names missing files: without them the audit would find nothing wrong.
std::vector<std::string> missing_files(const std::filesystem::path& run, const Experiment& e) {
  std::vector<std::string> missing;
  for (const NodeInfo& node : nodes()) {
    if (node.id == NodeId::kRecorder || node.id == NodeId::kLauncher || !takes_part(e, node.name)) continue;
    const std::string name = RunPaths::wal_name(node.name);
    if (!std::filesystem::exists(run / name)) missing.push_back(name + " is missing");
  }
  const RunPaths paths(run);
  if (std::filesystem::exists(paths.world_state_path()) &&
      !std::filesystem::exists(paths.world_record_path()))
    missing.push_back("world.rec is missing, though world/state shows that the lab was simulated");
  if (const std::string incomplete = runs::incomplete_text(run); !incomplete.empty())
    missing.push_back(incomplete + ": its records are not all here; firn runs collect fetches them");
  return missing;
}

// From the write-ahead files; where they are gone, from the run folder.
Experiment experiment_of(const std::filesystem::path& run) {
  const std::string config = runs::recorded_config(run);
  if (!config.empty()) return parse_experiment(config, "the recorded configuration");
  const std::filesystem::path file = RunPaths(run).experiment_path();
  return parse_experiment(read_file(file), file.string());
}

AuditVerdict path_verdict(const std::filesystem::path& run, AuditOptions options, bool real) {
  const runs::RunReader messages(run);
  const std::filesystem::path record = RunPaths(run).world_record_path();
  if (real || !std::filesystem::exists(record)) return audit_paths(messages, nullptr, options);
  std::vector<TrueFiring> firings;
  const plant::WorldHistory history = plant::read_history(record);
  if (history.damaged > 0)
    options.damage.push_back("the world's own record is damaged in " + std::to_string(history.damaged) +
                             " places");
  for (const plant::FiringRecord& f : history.firings)
    firings.push_back({f.trigger_us, f.last_us, std::int64_t(f.listed), std::int64_t(f.fired), f.valve + 1});
  return audit_paths(messages, &firings, options);
}

// The verdict of the nodes' and the world's records.
AuditVerdict records_verdict(const std::filesystem::path& run) {
  runs::require_run(run);
  runs::require_one_run(run);
  try {
    const Experiment e = experiment_of(run);
    AuditOptions options;
    options.time_scale = e.run.time_scale;
    options.damage = missing_files(run, e);
    for (const std::string& setting : runs::config_change(run, runs::recorded_config(run), {}).settings)
      options.damage.push_back("experiment.toml is not what the nodes recorded: " + setting);
    const bool real = !outside_ports(e).empty();  // the simulated rest of the lab knows of no droplet
    AuditVerdict verdict;
    if (prints_paths(e) || prints_lines(e)) {
      verdict = path_verdict(run, options, real);
    } else {
      const AuditRecord record = read_audit_record(run, OffsetTable(e.actuation));
      const auto truth = real ? std::nullopt : read_world_truth(run, e);
      verdict = audit(record, truth ? &*truth : nullptr, options);
    }
    verdict.real = real;
    if (real)
      verdict.notes.push_back(
          ports_text(e) +
          ". Held against each other are the records of the nodes and the counters of the "
          "instruments. Drops that a nozzle did not give, and the true time of the last one "
          "after a stop, are not known.");
    return verdict;
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

void compare_truth(const std::filesystem::path& run, AuditVerdict& verdict) {
  const runs::TruthCheck truth = runs::check_truth(run);
  for (const std::string& line : truth.differs) verdict.add(ViolationKind::kOtherTruth, line);
  verdict.notes.insert(verdict.notes.end(), truth.notes.begin(), truth.notes.end());
}

}  // namespace

AuditVerdict audit_records(const std::filesystem::path& run) {
  AuditVerdict verdict = records_verdict(run);
  compare_truth(run, verdict);
  return verdict;
}

AuditVerdict audit_run(const std::filesystem::path& run, const std::string& seal) {
  const runs::SealCheck seals = runs::check_seals(run);
  AuditVerdict verdict;
  try {
    verdict = records_verdict(run);
  } catch (const std::exception& e) {
    if (seals.whole()) throw;
    verdict.add(ViolationKind::kDamaged, e.what());
  }
  compare_truth(run, verdict);
  verdict.seal = seals.summary();
  verdict.notes.insert(verdict.notes.end(), seals.notes.begin(), seals.notes.end());
  std::vector<Violation> found;
  std::vector<std::string> lines = seals.lines();
  if (!seal.empty() && std::ranges::find(seals.seals, seal, &runs::Seal::digest) == seals.seals.end())
    lines.insert(lines.begin(), "seals: none has the digest " + seal);
  for (const runs::SealDifference& d : seals.derived) lines.push_back(to_text(d));
  for (const std::string& line : lines) found.push_back({ViolationKind::kAltered, line});
  verdict.violations_total += found.size();
  found.insert(found.end(), verdict.violations.begin(), verdict.violations.end());
  found.resize(std::min(found.size(), AuditVerdict::kKept));
  verdict.violations = std::move(found);
  return verdict;
}

}  // namespace firn::replay
