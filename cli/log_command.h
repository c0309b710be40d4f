// run_log describes, verifies, prints and repairs event logs (log.lcm, LCM logs of others), write-ahead files
// (nodes/<node>.wal) and record files (world.rec).
#pragma once

#include <cstdint>
#include <iosfwd>
#include <limits>
#include <string>
#include <vector>

namespace firn {

enum class LogAction { kInfo, kVerify, kCat, kRepair };

struct LogOptions {
  LogAction action = LogAction::kVerify;
  std::string file;
  bool json = false;                  ///< info, verify, repair: one JSON object; cat always prints JSON lines
  std::vector<std::string> types;     ///< info, cat: folders of .lcm files, or such files
  std::vector<std::string> channels;  ///< cat: only these; empty = all
  double from_s = -std::numeric_limits<double>::infinity();  ///< cat: node time, first
  double to_s = std::numeric_limits<double>::infinity();     ///< cat: node time, last
  std::int64_t count = -1;                                   ///< cat: at most so many lines; -1 = all
  bool full = false;                                         ///< cat: whole arrays
  std::string sources;  ///< repair: folder of write-ahead files; "" = nodes/ beside the log
};

/// Uses stdout and stderr. @returns kOk; kFailed if damage was found (info, verify, cat) or stays (repair);
/// kUsage if the file cannot be read.
int run_log(const LogOptions& options);

/// @throws UsageError: no event in the file, a record file
int log_info(const LogOptions& options, std::ostream& out);
int log_verify(const LogOptions& options, std::ostream& out);
/// One JSON object per line on `out`; damage on `err`.
int log_cat(const LogOptions& options, std::ostream& out, std::ostream& err);
int log_repair(const LogOptions& options, std::ostream& out);

}  // namespace firn
