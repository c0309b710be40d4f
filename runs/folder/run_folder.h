// RunFolder holds the folder of one run, runs/<utc>-<name>/, whose files RunPaths names; is_run tells it from
// other folders.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "config/meta.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "runs/folder/documents.h"
#include "runtime/fingerprint.h"
#include "runtime/node.h"
#include "runtime/write_ahead.h"

namespace firn::runs {

/// Returns the result that RUN_END reports; `outcome` is a RunOutcome.
RunResult result_of(int outcome, int layers, std::string reason);

/// Begins the name of a run folder that is being removed, and of one that a copy is arriving in.
inline constexpr const char *kRemoving = ".removing-", *kArriving = ".arriving-";

/// Returns true for the name of a folder that is no run, whatever it holds.
bool is_unfinished_name(std::string_view folder_name);

/// Returns true for the folder of a run: it has experiment.toml, provenance.json and nodes/, none of them a
/// link, and is neither being removed nor still arriving.
bool is_run(const std::filesystem::path& folder);
/// @throws UsageError "RUN: is no run folder: it has no nodes"
void require_run(const std::filesystem::path& folder);

class RunFolder : public RunPaths {
 public:
  /// Makes `<root>/<utc>-<name>` (a number is appended while it exists) with the resolved experiment, the
  /// inputs and the provenance, which holds `meta`; in it `results` is the fingerprint of the process.
  /// @throws UsageError if no folder can be made there; std::runtime_error naming the path and the system's
  /// reason.
  static RunFolder create(const std::filesystem::path& root, const Experiment& experiment,
                          const Blobs& inputs, const std::vector<std::string>& command_line,
                          const Fingerprint& results = {}, const Meta& meta = {});
  /// Opens a run folder.
  /// @throws UsageError: not a run folder, naming the missing file; std::runtime_error naming an unreadable
  /// file.
  static RunFolder open(const std::filesystem::path& path);

  const std::string& experiment_toml() const { return experiment_toml_; }
  std::int64_t run_id() const { return run_id_; }
  /// Returns role and SHA-256 of every input.
  const std::vector<std::pair<std::string, std::string>>& input_digests() const { return inputs_; }
  /// Reads provenance.json. @throws std::invalid_argument naming file and key
  ProvenanceDocument provenance() const;
  /// Returns the inputs, read back and checked against their SHA-256.
  Blobs inputs() const;
  /// Returns the first record of a node's write-ahead file.
  WalHead wal_head(std::string_view node, std::int32_t incarnation) const;

  std::optional<RunResult> result() const;           ///< nothing = the run has not ended
  void write_result(const RunResult& result) const;  ///< atomically
  void clear_result() const;                         ///< a resume begins

 private:
  using RunPaths::RunPaths;

  std::string experiment_toml_;
  std::int64_t run_id_ = 0;
  std::vector<std::pair<std::string, std::string>> inputs_;  // role, sha256
};

/// Returns the command line of this program, for the provenance.
std::vector<std::string> own_command_line();

}  // namespace firn::runs
