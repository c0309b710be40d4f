#include "runs/folder/run_folder.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "config/devices.h"
#include "config/labs.h"
#include "core/options/enumerators.h"
#include "files/digest.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/record/file.h"
#include "files/usage_error.h"
#include "files/utc_time.h"
#include "firn/enums.h"
#include "lcmtypes/schema.h"
#include "runs/folder/documents.h"
#include "runs/folder/one_run.h"
#include "runs/folder/origin.h"
#include "runtime/build_info.h"

namespace firn::runs {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

[[noreturn]] void refuse(const fs::path& path, const std::string& what) {
  throw UsageError(path.string() + ": " + what);
}

nlohmann::ordered_json provenance_of(const Experiment& e, std::int64_t run_id, const std::string& origin,
                                     const Blobs& inputs, const std::vector<std::string>& command_line,
                                     const Fingerprint& results, const Meta& meta) {
  utsname host{};
  uname(&host);
  nlohmann::ordered_json j;
  j["run_id"] = run_id;
  j["origin"] = origin;
  j["name"] = e.run.name;
  j["started_utc"] = utc_now();
  j["host"] = host.nodename;
  for (const MetaEntry& m : meta) std::visit([&](const auto& value) { j["meta"][m.key] = value; }, m.value);
  j["version"] = build_version();
  j["commit"] = build_commit();
  j["sources"] = build_sources();
  if (const BuildDiff diff = build_diff(); !diff.missing.empty())
    j["sources_diff"] = diff.missing;
  else if (!diff.text.empty())
    j["sources_diff"] = RunPaths::kSourcesDiff;
  j["platform"] = platform_description();
  if (!results.empty()) j["results"] = fingerprint_texts(results);
  j["kernel"] = std::string(host.sysname) + " " + host.release + " " + host.machine;
  j["command_line"] = command_line;
  j["sealed"] = true;  // the folder has seals since its first incarnation began
  j["scheme"] = e.control.scheme;
  j["plant_model"] = lab_of(e).deposition == Deposition::kDroplets ? e.plant.model : e.lab.kind;
  j["seeds"] = {{"plant", e.plant.seed}, {"control", e.control.seed}};
  for (const Blob& b : inputs)
    j["inputs"].push_back({{"role", b.role}, {"sha256", b.sha256}, {"bytes", b.bytes.size()}});
  return j;
}

// Name of a part of a run that is not in the folder; null: it is a run.
const char* missing_part(const fs::path& folder) {
  const RunPaths run(folder);
  const auto is = [](const fs::path& path, fs::file_type type) {
    std::error_code gone;
    return fs::symlink_status(path, gone).type() == type;
  };
  return !is(run.experiment_path(), fs::file_type::regular)   ? RunPaths::kExperiment
         : !is(run.provenance_path(), fs::file_type::regular) ? RunPaths::kProvenance
         : !is(run.nodes_path(), fs::file_type::directory)    ? RunPaths::kNodes
                                                              : nullptr;
}

}  // namespace

bool is_run(const fs::path& folder) {
  return !missing_part(folder) && !is_unfinished_name(folder.filename().string());
}

bool is_unfinished_name(std::string_view name) {
  return name.starts_with(kRemoving) || name.starts_with(kArriving);
}

void require_run(const fs::path& folder) {
  if (!fs::is_directory(folder)) refuse(folder, "is no run folder (no such directory)");
  if (const char* part = missing_part(folder))
    refuse(folder, std::string("is no run folder: it has no ") + part);
}

RunResult result_of(int outcome, int layers, std::string reason) {
  static constexpr const char* kOutcomes[] = {"finished", "ended early", "stopped safely",
                                              "waits for operator", "out of tolerance"};
  static_assert(std::size(kOutcomes) == kTableSize<RunOutcome>);
  const int known = std::clamp(outcome, 0, int(std::size(kOutcomes)) - 1);
  const int status = known == int(RunOutcome::kFinished)         ? kOk
                     : known == int(RunOutcome::kOutOfTolerance) ? kOutOfTolerance
                                                                 : kSafetyStop;
  return {kOutcomes[known], status, layers, std::move(reason)};
}

std::vector<std::string> own_command_line() {
  const std::string text = read_file("/proc/self/cmdline");  // arguments, each ended by a zero byte
  std::vector<std::string> arguments;
  for (std::size_t at = 0; at < text.size(); at += arguments.back().size() + 1)
    arguments.emplace_back(text.c_str() + at);
  return arguments;
}

RunFolder RunFolder::create(const fs::path& root, const Experiment& e, const Blobs& inputs,
                            const std::vector<std::string>& command_line, const Fingerprint& results,
                            const Meta& meta) {
  const std::string stem = utc_now("%Y%m%dT%H%M%SZ") + "-" + e.run.name;
  std::error_code error;
  fs::create_directories(root, error);
  if (error) refuse(root, "cannot be made: " + error.message() + "; choose another folder with --runs");
  fs::path path;
  for (int n = 0;; ++n) {
    path = root / (n ? stem + "-" + std::to_string(n + 1) : stem);
    if (fs::create_directory(path, error)) break;
    if (error) refuse(path, "cannot be made: " + error.message() + "; choose another folder with --runs");
  }
  RunFolder run(path);
  run.run_id_ = std::chrono::duration_cast<std::chrono::microseconds>(
                    std::chrono::system_clock::now().time_since_epoch())
                    .count();
  for (const char* sub : {kInputs, kNodes, kPorts, kWorld}) fs::create_directory(path / sub);
  for (const Blob& b : inputs) {
    write_file_atomically(run.input_path(b.sha256),
                          {reinterpret_cast<const char*>(b.bytes.data()), b.bytes.size()});
    run.inputs_.emplace_back(b.role, b.sha256);
  }
  if (const BuildDiff diff = build_diff(); !diff.text.empty())
    write_file_atomically(run.sources_diff_path(), diff.text);
  run.experiment_toml_ = dump(e);
  write_file_atomically(run.experiment_path(), run.experiment_toml_);
  const std::string origin = run_origin(run.run_id_, run.experiment_toml_, run.inputs_);
  write_file_atomically(
      run.provenance_path(),
      provenance_of(e, run.run_id_, origin, inputs, command_line, results, meta).dump(2) + "\n");
  return run;
}

RunFolder RunFolder::open(const fs::path& path) {
  require_run(path);
  require_one_run(path);
  RunFolder run(path);
  run.experiment_toml_ = read_file(run.experiment_path());
  const fs::path file = run.provenance_path();
  try {
    ProvenanceDocument p = parse_provenance(read_file(file), file.string());
    if (!p.run_id || !p.has_inputs) refuse(file, "has no run_id or no inputs");
    run.run_id_ = *p.run_id;
    run.inputs_ = std::move(p.inputs);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  return run;
}

ProvenanceDocument RunFolder::provenance() const {
  const fs::path file = provenance_path();
  return parse_provenance(read_file(file), file.string());
}

Blobs RunFolder::inputs() const {
  Blobs blobs;
  for (const auto& [role, sha] : inputs_) {
    const fs::path file = input_path(sha);
    const record::MappedFile mapped(file, record::MappedFile::Packed::kAsIs);
    const auto bytes = mapped.bytes();
    if (sha256_hex(bytes) != sha)
      fail(file, "content does not have the SHA-256 of its name (input '" + role + "' was changed)");
    blobs.push_back({role, sha, {bytes.begin(), bytes.end()}});
  }
  return blobs;
}

WalHead RunFolder::wal_head(std::string_view node, std::int32_t incarnation) const {
  WalHead h;
  h.node = node;
  h.run_id = run_id_;
  h.incarnation = incarnation;
  h.commit = build_commit();
  h.platform = platform_description();
  h.config_toml = experiment_toml_;
  h.type_texts = lcm_type_texts();
  h.blobs = inputs_;
  return h;
}

std::optional<RunResult> RunFolder::result() const {
  const fs::path file = result_path();
  if (!fs::exists(file)) return std::nullopt;
  try {
    return parse_result(read_file(file), file.string());
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

void RunFolder::write_result(const RunResult& r) const {
  auto j = nlohmann::ordered_json::parse(result_text(r));
  j["instruments"] = ports_text(parse_experiment(experiment_toml_, kExperiment));
  write_file_atomically(result_path(), j.dump(2) + "\n");
}

void RunFolder::clear_result() const { fs::remove(result_path()); }

}  // namespace firn::runs
