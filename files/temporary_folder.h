// TemporaryFolder is a fresh folder that goes, with everything in it, at the end.
#pragma once

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "files/usage_error.h"

namespace firn {

class TemporaryFolder {
 public:
  /// @param stem its name begins with "firn-" and it @throws UsageError: no folder can be made below `place`
  explicit TemporaryFolder(std::string_view stem,
                           const std::filesystem::path& place = std::filesystem::temp_directory_path()) {
    std::string name = (place / ("firn-" + std::string(stem) + "-XXXXXX")).string();
    if (!::mkdtemp(name.data()))
      throw UsageError(name + ": no folder can be made there: " + std::strerror(errno));
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view file) const { return path_ / file; }

 private:
  std::filesystem::path path_;
};

}  // namespace firn
