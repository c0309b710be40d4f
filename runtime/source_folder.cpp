#include "runtime/source_folder.h"

#include <system_error>

namespace firn {

namespace fs = std::filesystem;

fs::path source_folder() {
  std::error_code error;
  const fs::path home = fs::read_symlink("/proc/self/exe", error).parent_path().parent_path();
  if (!error && home.filename() == "firn" && home.parent_path().filename() == "lib") {
    const fs::path installed = home.parent_path().parent_path() / "share" / "firn";
    if (fs::is_directory(installed / "labs", error)) return installed;
  }
  return FIRN_SOURCE_DIR;
}

}  // namespace firn
