#include "print/folder/run_folder.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>

#include "config/devices.h"
#include "config/labs.h"
#include "files/digest.h"
#include "files/json.h"
#include "files/run_documents.h"
#include "files/usage_error.h"
#include "firn/enums.h"
#include "lcmtypes/schema.h"
#include "print/exit_codes.h"
#include "runtime/build_info.h"

namespace firn {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

[[noreturn]] void refuse(const fs::path& path, const std::string& what) {
  throw UsageError(path.string() + ": " + what);
}

std::string utc_now(const char* format) {
  const std::time_t t = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm tm{};
  gmtime_r(&t, &tm);
  char text[64];
  std::strftime(text, sizeof text, format, &tm);
  return text;
}

nlohmann::ordered_json provenance(const Experiment& e, std::int64_t run_id, const Blobs& inputs,
                                  const std::vector<std::string>& command_line) {
  utsname host{};
  uname(&host);
  nlohmann::ordered_json j;
  j["run_id"] = run_id;
  j["name"] = e.run.name;
  j["started_utc"] = utc_now("%Y-%m-%dT%H:%M:%SZ");
  j["commit"] = build_commit();
  j["sources"] = build_sources();
  if (const BuildDiff diff = build_diff(); !diff.missing.empty())
    j["sources_diff"] = diff.missing;
  else if (!diff.text.empty())
    j["sources_diff"] = "sources.diff";
  j["platform"] = platform_description();
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

}  // namespace

bool can_go_on(const RunResult& r) { return r.status != kOk && r.outcome != "out of tolerance"; }

RunResult result_of(int outcome, int layers, std::string reason) {
  static constexpr const char* kOutcomes[] = {"finished", "ended early", "stopped safely",
                                              "waits for operator", "out of tolerance"};
  const int known = std::clamp(outcome, 0, 4);
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
                            const std::vector<std::string>& command_line) {
  RunFolder run;
  const std::string stem = utc_now("%Y%m%dT%H%M%SZ") + "-" + e.run.name;
  std::error_code error;
  fs::create_directories(root, error);
  if (error) refuse(root, "cannot be made: " + error.message() + "; choose another folder with --runs");
  for (int n = 0;; ++n) {
    run.path_ = root / (n ? stem + "-" + std::to_string(n + 1) : stem);
    if (fs::create_directory(run.path_, error)) break;
    if (error)
      refuse(run.path_, "cannot be made: " + error.message() + "; choose another folder with --runs");
  }
  run.run_id_ = std::chrono::duration_cast<std::chrono::microseconds>(
                    std::chrono::system_clock::now().time_since_epoch())
                    .count();
  for (const char* sub : {"inputs", "nodes", "io", "world"}) fs::create_directory(run.path_ / sub);
  for (const Blob& b : inputs) {
    write_file_atomically(run.path_ / "inputs" / b.sha256,
                          {reinterpret_cast<const char*>(b.bytes.data()), b.bytes.size()});
    run.inputs_.emplace_back(b.role, b.sha256);
  }
  if (const BuildDiff diff = build_diff(); !diff.text.empty())
    write_file_atomically(run.path_ / "sources.diff", diff.text);
  run.experiment_toml_ = dump(e);
  write_file_atomically(run.path_ / "experiment.toml", run.experiment_toml_);
  write_file_atomically(run.path_ / "provenance.json",
                        provenance(e, run.run_id_, inputs, command_line).dump(2) + "\n");
  return run;
}

RunFolder RunFolder::open(const fs::path& path) {
  RunFolder run;
  run.path_ = path;
  if (!fs::is_directory(path)) refuse(path, "is no run folder (no such directory)");
  for (const char* part : {"experiment.toml", "provenance.json", "nodes"})
    if (!fs::exists(path / part)) refuse(path, std::string("is no run folder: it has no ") + part);
  run.experiment_toml_ = read_file(path / "experiment.toml");
  const fs::path file = path / "provenance.json";
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

fs::path RunFolder::wal_path(std::string_view node) const {
  return nodes_path() / (std::string(node) + ".wal");
}

Blobs RunFolder::inputs() const {
  Blobs blobs;
  for (const auto& [role, sha] : inputs_) {
    const fs::path file = path_ / "inputs" / sha;
    const std::string text = read_file(file);
    const auto bytes = std::as_bytes(std::span(text));
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
  const fs::path file = path_ / "result.json";
  if (!fs::exists(file)) return std::nullopt;
  try {
    const ResultDocument r = parse_result(read_file(file), file.string());
    return RunResult{r.outcome, r.status, r.layers, r.reason};
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

void RunFolder::write_result(const RunResult& r) const {
  const nlohmann::ordered_json j = {
      {"outcome", r.outcome},
      {"status", r.status},
      {"layers", r.layers},
      {"reason", r.reason},
      {"instruments", ports_text(parse_experiment(experiment_toml_, "experiment.toml"))}};
  write_file_atomically(path_ / "result.json", j.dump(2) + "\n");
}

void RunFolder::clear_result() const { fs::remove(path_ / "result.json"); }

}  // namespace firn
