#include "page/thumbnails.h"

#include <sys/stat.h>

#include <algorithm>
#include <utility>

#include "files/run_paths.h"

namespace firn::page {

std::string Thumbnails::last_change(const std::filesystem::path& run) {
  const RunPaths paths(run);
  std::string text;
  for (const auto& file : {paths.provenance_path(), paths.result_path(), paths.log_path()}) {
    struct ::stat s {};
    if (::stat(file.c_str(), &s) == 0)
      text += std::to_string(s.st_ino) + "." + std::to_string(s.st_size) + "." +
              std::to_string(s.st_mtim.tv_sec) + "." + std::to_string(s.st_mtim.tv_nsec);
    text += "-";
  }
  return text;
}

std::string Thumbnails::get(const std::filesystem::path& run) {
  const std::string change = last_change(run);
  {
    const std::lock_guard lock(mutex_);
    if (const auto at = kept_.find(run); at != kept_.end() && at->second.change == change) {
      at->second.used = ++uses_;
      return at->second.picture;
    }
  }
  const std::string picture = draw_(run);
  const std::lock_guard lock(mutex_);
  Kept& kept = kept_[run];
  if (kept.used > 0) bytes_ -= kept.bytes();
  kept = {change, picture, ++uses_};
  bytes_ += kept.bytes();
  make_room();
  return picture;
}

std::size_t Thumbnails::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

void Thumbnails::make_room() {
  while (bytes_ > most_bytes_ && kept_.size() > 1) {
    const auto oldest = std::ranges::min_element(kept_, {}, [](const auto& one) { return one.second.used; });
    bytes_ -= oldest->second.bytes();
    kept_.erase(oldest);
  }
}

}  // namespace firn::page
