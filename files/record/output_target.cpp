#include "files/record/output_target.h"

#include <cerrno>

#include "files/record/file.h"

namespace firn::logfile {

std::filesystem::path output_target(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (!fs::exists(status)) return file;
  if (fs::is_directory(status)) throw FileError(file, 0, "cannot be replaced", EISDIR);
  if (!fs::is_regular_file(status))
    throw FileError(file, 0, "is no regular file and cannot be replaced", EINVAL);
  const fs::path target = fs::canonical(file, error);
  return error ? file : target;
}

}  // namespace firn::logfile
