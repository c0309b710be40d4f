// RunFolder holds the folder of one run: runs/<utc>-<name>/{experiment.toml, provenance.json, inputs/,
// nodes/, log.lcm, …}.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "files/text_file.h"
#include "runtime/node.h"
#include "runtime/write_ahead.h"

namespace firn {

struct RunResult {
  std::string
      outcome;     ///< "finished", "ended early", "stopped safely", "waits for operator", "out of tolerance"
  int status = 0;  ///< exit status of the print
  int layers = 0;
  std::string reason;
};

/// Returns true if some of the layers are not printed.
bool can_go_on(const RunResult& result);
/// Returns the result that RUN_END reports; `outcome` is a RunOutcome.
RunResult result_of(int outcome, int layers, std::string reason);

class RunFolder {
 public:
  /// Makes `<root>/<utc>-<name>` (a number is appended while it exists) with the resolved experiment, the
  /// inputs and the provenance. @throws UsageError if no folder can be made there; std::runtime_error naming
  /// the path and the system's reason.
  static RunFolder create(const std::filesystem::path& root, const Experiment& experiment,
                          const Blobs& inputs, const std::vector<std::string>& command_line);
  /// Opens a run folder.
  /// @throws UsageError: not a run folder, naming the missing file; std::runtime_error naming an unreadable
  /// file.
  static RunFolder open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path nodes_path() const { return path_ / "nodes"; }
  std::filesystem::path wal_path(std::string_view node) const;
  std::filesystem::path log_path() const { return path_ / "log.lcm"; }
  std::filesystem::path world_record_path() const { return path_ / "world.rec"; }

  const std::string& experiment_toml() const { return experiment_toml_; }
  std::int64_t run_id() const { return run_id_; }
  /// Returns the inputs, read back and checked against their SHA-256.
  Blobs inputs() const;
  /// Returns the first record of a node's write-ahead file.
  WalHead wal_head(std::string_view node, std::int32_t incarnation) const;

  std::optional<RunResult> result() const;           ///< nothing = the run has not ended
  void write_result(const RunResult& result) const;  ///< atomically
  void clear_result() const;                         ///< a resume begins

 private:
  std::filesystem::path path_;
  std::string experiment_toml_;
  std::int64_t run_id_ = 0;
  std::vector<std::pair<std::string, std::string>> inputs_;  // role, sha256
};

/// Returns the command line of this program, for the provenance.
std::vector<std::string> own_command_line();

}  // namespace firn
