// RunPaths names the files of a run folder, and no other source spells them. It stands in files/ because the
// writers of a run (runtime/, plant/, procs/recorder) lie below runs/, which holds the folder as a whole.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/record/open_file.h"

namespace firn {

class RunPaths {
 public:
  // Names relative to the run folder.
  static constexpr const char *kExperiment = record::kRunExperiment, *kProvenance = record::kRunProvenance,
                              *kResult = "result.json", *kSourcesDiff = "sources.diff", *kClocks = "clocks",
                              *kLog = "log.lcm", *kWorldRecord = "world.rec", *kMetrics = "metrics.csv",
                              *kReport = "report.html", *kNotes = "notes.jsonl", *kLock = "lock",
                              *kInstrumentsLock = "io/lock";
  static constexpr const char* kOldNotes = "notes.json";  // of Firn 0.1, without author and time
  // Folders in it.
  static constexpr const char *kInputs = "inputs", *kNodes = "nodes", *kPorts = "io", *kWorld = "world",
                              *kSeals = "seals", *kHosts = "hosts";
  // Endings of the files in nodes/: of nodes, and of launcher and recorder.
  static constexpr const char *kWal = ".wal", *kSent = ".sent";

  RunPaths() = default;
  explicit RunPaths(std::filesystem::path run) : path_(std::move(run)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path experiment_path() const { return path_ / kExperiment; }
  std::filesystem::path provenance_path() const { return path_ / kProvenance; }
  std::filesystem::path result_path() const { return path_ / kResult; }
  std::filesystem::path sources_diff_path() const { return path_ / kSourcesDiff; }
  std::filesystem::path clocks_path() const { return path_ / kClocks; }
  std::filesystem::path metrics_path() const { return path_ / kMetrics; }
  std::filesystem::path report_path() const { return path_ / kReport; }
  std::filesystem::path notes_path() const { return path_ / kNotes; }
  std::filesystem::path old_notes_path() const { return path_ / kOldNotes; }

  std::filesystem::path inputs_path() const { return path_ / kInputs; }
  std::filesystem::path input_path(std::string_view sha256) const { return inputs_path() / sha256; }

  std::filesystem::path nodes_path() const { return path_ / kNodes; }
  std::filesystem::path wal_path(std::string_view node) const { return path_ / wal_name(node); }
  std::filesystem::path sent_path(std::string_view node) const { return path_ / sent_name(node); }
  std::filesystem::path log_path() const { return path_ / kLog; }

  std::filesystem::path ports_path() const { return path_ / kPorts; }
  std::filesystem::path port_path(std::string_view port) const { return ports_path() / port; }
  std::filesystem::path instruments_lock_path() const { return path_ / kInstrumentsLock; }

  std::filesystem::path world_path() const { return path_ / kWorld; }
  std::filesystem::path world_state_path() const { return world_path() / "state"; }
  std::filesystem::path world_journal_path() const { return world_path() / "inputs"; }
  std::filesystem::path world_record_path() const { return path_ / kWorldRecord; }

  std::filesystem::path seals_path() const { return path_ / kSeals; }
  std::filesystem::path hosts_path() const { return path_ / kHosts; }

  /// "nodes/NODE.wal"
  static std::string wal_name(std::string_view node) { return in_nodes(node, kWal); }
  /// "nodes/NODE.sent"
  static std::string sent_name(std::string_view node) { return in_nodes(node, kSent); }
  /// Returns true for the name of a write-ahead file of a node.
  static bool is_wal(const std::filesystem::path& file) { return file.extension() == kWal; }
  /// Returns true for a write-ahead file of a node, of the launcher or of the recorder.
  static bool is_sent_record(const std::filesystem::path& file) {
    return is_wal(file) || file.extension() == kSent;
  }

  /// Returns the nodes' write-ahead files, sorted; none without the folder.
  std::vector<std::filesystem::path> wal_files() const {
    std::vector<std::filesystem::path> files;
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(nodes_path(), missing))
      if (is_wal(entry.path())) files.push_back(entry.path());
    std::ranges::sort(files);
    return files;
  }

 private:
  static std::string in_nodes(std::string_view node, const char* ending) {
    return std::string(kNodes) + "/" + std::string(node) + ending;
  }

  std::filesystem::path path_;
};

}  // namespace firn
