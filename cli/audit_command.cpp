#include "cli/audit_command.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "cli/option_set.h"
#include "config/devices.h"
#include "config/experiment.h"
#include "config/labs.h"
#include "files/digest.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "plant/inkjet/model.h"
#include "plant/record/record.h"
#include "print/exit_codes.h"
#include "print/folder/imported_run.h"
#include "print/folder/node_makers.h"
#include "print/folder/run_config.h"
#include "print/folder/seal_check.h"
#include "print/folder/truth_check.h"
#include "replay/path_audit.h"
#include "replay/run_messages.h"

namespace firn {
namespace {

replay::Shot::Outcome outcome_of(plant::ShotOutcome outcome) {
  switch (outcome) {
    case plant::ShotOutcome::kFired:
      return replay::Shot::Outcome::kFired;
    case plant::ShotOutcome::kMissed:
      return replay::Shot::Outcome::kMissed;
    default:
      return replay::Shot::Outcome::kIgnored;
  }
}

}  // namespace

std::optional<replay::WorldTruth> read_world_truth(const std::filesystem::path& run, const Experiment& e) {
  const std::filesystem::path path = run / "world.rec";
  if (!std::filesystem::exists(path)) return {};
  const plant::WorldHistory history = plant::read_history(path);
  replay::WorldTruth truth;
  truth.damaged = history.damaged;
  for (const plant::ShotRecord& s : history.shots) {
    plant::NearestCell cell{s.i, s.j};
    // Position of the second nozzle as the lab believed it: its error belongs to nature, and firn calibrate
    // finds it.
    if (s.nozzle == 1)
      cell = plant::nearest_cell(e.grid, s.x_mm + e.jet_b.offset_x_mm, s.y_mm + e.jet_b.offset_y_mm);
    truth.shots.push_back({s.t_us, cell.i, cell.j, s.exposures, outcome_of(s.outcome),
                           s.nozzle == 1 ? Material::kB : Material::kA});
  }
  for (const plant::DeviceRecord& d : history.devices)
    if (d.event == plant::DeviceEvent::kJetArmed || d.event == plant::DeviceEvent::kJetDisarmed)
      truth.jet.push_back({d.t_us, d.event == plant::DeviceEvent::kJetArmed,
                           d.port == plant::Port::kJetB ? Material::kB : Material::kA});
  return truth;
}

namespace {

// Names missing files: without them the audit would find nothing wrong.
std::vector<std::string> missing_files(const std::filesystem::path& run, const Experiment& e) {
  std::vector<std::string> missing;
  for (const NamedMaker& node : taking_part(e)) {
    const std::string name = "nodes/" + std::string(info(node.id).name) + ".wal";
    if (!std::filesystem::exists(run / name)) missing.push_back(name + " is missing");
  }
  if (std::filesystem::exists(run / "world" / "state") && !std::filesystem::exists(run / "world.rec"))
    missing.push_back("world.rec is missing, though world/state shows that the lab was simulated");
  return missing;
}

// From the write-ahead files; where they are gone, from the run folder.
Experiment experiment_of(const std::filesystem::path& run) {
  const std::string config = recorded_config(run);
  if (!config.empty()) return parse_experiment(config, "the recorded configuration");
  const std::filesystem::path file = run / "experiment.toml";
  return std::filesystem::exists(file) ? parse_experiment(read_file(file), file.string()) : Experiment{};
}

replay::AuditVerdict path_verdict(const std::filesystem::path& run, replay::AuditOptions options, bool real) {
  const replay::RunMessages messages(run);
  if (real || !std::filesystem::exists(run / "world.rec"))
    return replay::audit_paths(messages, nullptr, options);
  std::vector<replay::TrueFiring> firings;
  const plant::WorldHistory history = plant::read_history(run / "world.rec");
  if (history.damaged > 0)
    options.damage.push_back("the world's own record is damaged in " + std::to_string(history.damaged) +
                             " places");
  for (const plant::FiringRecord& f : history.firings)
    firings.push_back({f.trigger_us, f.last_us, std::int64_t(f.listed), std::int64_t(f.fired), f.valve + 1});
  return replay::audit_paths(messages, &firings, options);
}

}  // namespace

namespace {

// The verdict of the nodes' and the world's records.
replay::AuditVerdict records_verdict(const std::filesystem::path& run) {
  try {
    const Experiment e = experiment_of(run);
    replay::AuditOptions options;
    options.time_scale = e.run.time_scale;
    options.damage = missing_files(run, e);
    const bool real = !outside_ports(e).empty();  // the simulated rest of the lab knows of no droplet
    replay::AuditVerdict verdict;
    if (prints_paths(e) || prints_lines(e)) {
      verdict = path_verdict(run, options, real);
    } else {
      const replay::AuditRecord record = replay::read_audit_record(run);
      const auto truth = real ? std::nullopt : read_world_truth(run, e);
      verdict = replay::audit(record, truth ? &*truth : nullptr, options);
    }
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

}  // namespace

replay::AuditVerdict audit_verdict(const std::filesystem::path& run, const std::string& seal) {
  if (!seal.empty() && !is_sha256_hex(seal))
    throw UsageError("--seal '" + seal.substr(0, 100) + "': is no SHA-256, 64 hexadecimal digits");
  refuse_imported(run, "firn audit");
  const SealCheck seals = check_seals(run);
  replay::AuditVerdict verdict;
  try {
    verdict = records_verdict(run);
  } catch (const std::exception& e) {
    if (seals.whole()) throw;
    verdict.add(replay::ViolationKind::kDamaged, e.what());
  }
  const TruthCheck truth = check_truth(run);
  for (const std::string& line : truth.differs) verdict.add(replay::ViolationKind::kOtherTruth, line);
  verdict.notes.insert(verdict.notes.end(), truth.notes.begin(), truth.notes.end());
  verdict.seal = seals.summary();
  verdict.notes.insert(verdict.notes.end(), seals.notes.begin(), seals.notes.end());
  std::vector<replay::Violation> found;
  std::vector<std::string> lines = seals.lines();
  if (!seal.empty() && std::ranges::find(seals.seals, seal, &Seal::digest) == seals.seals.end())
    lines.insert(lines.begin(), "seals: none has the digest " + seal);
  for (const SealDifference& d : seals.derived) lines.push_back(to_text(d));
  for (const std::string& line : lines) found.push_back({replay::ViolationKind::kAltered, line});
  verdict.violations_total += found.size();
  found.insert(found.end(), verdict.violations.begin(), verdict.violations.end());
  found.resize(std::min(found.size(), replay::AuditVerdict::kKept));
  verdict.violations = std::move(found);
  return verdict;
}

int run_audit(const AuditCommandOptions& options) {
  const replay::AuditVerdict verdict = audit_verdict(options.run, options.seal);
  const std::string text = options.json ? replay::to_json(verdict) + "\n" : replay::to_text(verdict);
  std::fputs(text.c_str(), stdout);
  return verdict.clean() ? kOk : kFailed;
}

void declare_audit(OptionSet& options) {
  auto& o = options.calls(run_audit);
  options.option("RUN", o.run, "run folder").required();
  options.option("--seal", o.seal,
                 "DIGEST that one of the run's seals must have, as an earlier audit printed it");
  options.json_flag(o.json);
}

}  // namespace firn
