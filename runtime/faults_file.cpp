#include "runtime/faults_file.h"

#include <fstream>
#include <iterator>

namespace firn {

FaultsFile::FaultsFile(std::filesystem::path path, bool on) : path_(std::move(path)), on_(on) {
  std::ifstream in(path_);
  if (on_ && in) before_ = parse_lossy_counts(std::string(std::istreambuf_iterator<char>(in), {}));
}

void FaultsFile::write(const LossyCounts& c) {
  if (!on_) return;
  const LossyCounts sum{before_.passed + c.passed, before_.lost + c.lost, before_.duplicated + c.duplicated,
                        before_.reordered + c.reordered, before_.delayed + c.delayed};
  const std::filesystem::path fresh = path_.string() + ".new";
  std::ofstream(fresh) << to_text(sum);
  std::filesystem::rename(fresh, path_);  // a kill leaves the old counts or the new ones
}

void FaultsFile::write_sometimes(const LossyCounts& counts, std::int64_t wall_us) {
  if (wall_us < next_us_) return;
  next_us_ = wall_us + 100'000;
  write(counts);
}

}  // namespace firn
