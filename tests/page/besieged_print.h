// Prints that a besieged page watches, and the comparison of their records with those of a print that nobody
// watches.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "print/process/child_process.h"
#include "runs/folder/run_folder.h"
#include "tests/page/page_attack.h"

namespace firn::test {

/// The process `page` of a run.
class PageOf {
 public:
  explicit PageOf(const std::filesystem::path& run);
  ~PageOf() { process_.kill(); }  ///< SIGKILL
  bool running() { return process_.running(); }
  std::string address;  ///< empty: it did not begin

 private:
  ChildProcess process_;
};

/// A part of some layers.
runs::RunFolder part_to_besiege(const std::filesystem::path& root);

struct Siege {
  int killed = 0;            ///< kill -9 of the page
  std::int64_t frames = 0;   ///< that reached the page
  bool page_serves = false;  ///< after the siege
};
/// Prints into `run` in this process. The page is besieged, killed after every third layer and begun anew; a
/// layer waits until its share of the frames is sent. @throws std::runtime_error: a print that does not
/// finish
Siege print_besieged(const runs::RunFolder& run, const PageAttack::Size& size);
/// The same without a page.
void print_alone(const runs::RunFolder& run);

/// Returns the names of the write-ahead files whose records differ: events, and outputs without the handler's
/// wall time and the run's number, the time at which its folder was made.
std::vector<std::string> differing_files(const runs::RunFolder& a, const runs::RunFolder& b);

}  // namespace firn::test
