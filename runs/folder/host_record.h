// HostRecord says which processes of a run were on another computer, and whether their records are all here:
// RUN/hosts/NAME.json.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace firn::runs {

struct HostRecord {
  std::string name;                ///< in [hosts]
  std::string address, program;    ///< for ssh; of firn there
  std::vector<std::string> nodes;  ///< its processes
  bool complete = false;           ///< the records that they made are in this folder, compared byte by byte
};

void write_host_record(const std::filesystem::path& run, const HostRecord& record);
/// Returns the records by name; none for a run on one computer. A run may come from a stranger: names,
/// addresses and processes are those that a lab file may have.
/// @throws std::runtime_error naming file and member
std::vector<HostRecord> host_records(const std::filesystem::path& run);
/// Returns "incomplete: host bench (jet, stage)" for the hosts whose records are not all here; empty: all
/// are.
std::string incomplete_text(const std::filesystem::path& run);

}  // namespace firn::runs
