#include "runs/folder/origin.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <span>

#include "config/error.h"
#include "config/experiment.h"
#include "core/control/python_scheme.h"
#include "files/digest.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/documents.h"
#include "runs/folder/run_folder.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

// The system's pages ask not to publish the number itself; a digest of it and more is no way back.
std::string machine_secret() {
  for (const char* file :
       {"/etc/machine-id", "/var/lib/dbus/machine-id", "/proc/sys/kernel/random/boot_id"}) {
    try {
      if (std::string text = read_file(file); text.size() >= 32) return text;
    } catch (const UsageError&) {
    }
  }
  return "";
}

}  // namespace

std::string run_origin(std::int64_t run_id, const std::string& config_toml, const InputDigests& unsorted) {
  const std::string secret = machine_secret();
  if (secret.empty()) return "";
  Sha256 digest;
  const auto add = [&](const std::string& text) {  // its length first: no two lists have the same bytes
    const std::string sized = std::to_string(text.size()) + ":" + text;
    digest.add(std::as_bytes(std::span(sized)));
  };
  for (const std::string& text :
       {std::string("firn run"), secret, std::to_string(::geteuid()), std::to_string(run_id), config_toml})
    add(text);
  InputDigests inputs = unsorted;
  std::ranges::sort(inputs);
  for (const auto& [role, sha256] : inputs) {
    add(role);
    add(sha256);
  }
  return digest.hex();
}

bool is_own_run(const fs::path& run, std::int64_t run_id, const std::string& config_toml,
                const InputDigests& inputs) {
  struct stat s {};
  if (::stat(run.c_str(), &s) != 0 || s.st_uid != ::geteuid()) return false;
  const fs::path file = RunPaths(run).provenance_path();
  const std::string told = parse_provenance(read_file(file), file.string()).text("origin");
  return !told.empty() && told == run_origin(run_id, config_toml, inputs);
}

std::string python_of(const std::string& config_toml, const std::string& node) {
  std::string found;
  const auto look = [&](const char* key, const std::string& text, const char* of) {
    if ((node.empty() || node == of) && control::is_python_scheme(text))
      found += (found.empty() ? "" : ", ") + std::string(key) + " = " + text;
  };
  try {
    const Experiment e = parse_recorded_experiment(config_toml, "the recorded configuration");
    look("control.scheme", e.control.scheme, "controller");
    look("estimator.droplets", e.estimator.droplets, "droplet_estimator");
    look("plant.model", e.plant.model, "world");
    // A replay feeds a driver the answers of its class: a print that goes on runs it, and no replay.
    if (node.empty())
      for (const auto& [of, kind] : e.devices.kind) look(("devices." + of + ".kind").c_str(), kind, "");
  } catch (const std::exception&) {  // whoever builds the node names it, and may read more than this
    if (config_toml.find("python:") != std::string::npos) found = "python:";
  }
  return found;
}

namespace {

void require_own(const fs::path& path, const RunFolder& run, const std::string& what,
                 const std::string& code) {
  if (code.empty() || is_own_run(path, run.run_id(), run.experiment_toml(), run.input_digests())) return;
  throw UsageError(path.string() + ": has " + what + " (" + code +
                   ") recorded by another user or host, or changed since; --run-python runs it");
}

// Commands that a print starts, and hosts that it reaches.
std::string commands_of(const std::string& config_toml) try {
  const Experiment e = parse_recorded_experiment(config_toml, "the recorded configuration");
  std::string found;
  const auto add = [&](const std::string& key, const std::string& value) {
    found += (found.empty() ? "" : ", ") + key + " = " + value;
  };
  for (const auto& [name, program] : e.own_programs) add("nodes." + name + ".command", program.command);
  for (const auto& [name, address] : e.hosts.address) add("hosts." + name, address);
  return found;
} catch (const ConfigError&) {
  return "";  // the print reads the same text, and names its file
}

}  // namespace

void require_own_python(const fs::path& path, bool run_python) {
  if (run_python) return;
  const RunFolder run = RunFolder::open(path);
  require_own(path, run, "Python code", python_of(run.experiment_toml(), ""));
}

void require_own_resume(const fs::path& path, bool run_python) {
  if (run_python) return;
  const RunFolder run = RunFolder::open(path);
  require_own(path, run, "Python code", python_of(run.experiment_toml(), ""));
  require_own(path, run, "commands or hosts", commands_of(run.experiment_toml()));
}

}  // namespace firn::runs
