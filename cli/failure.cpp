#include "cli/failure.h"

#include <cerrno>
#include <filesystem>
#include <new>

#include "config/error.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/record/file.h"
#include "files/record/packed.h"
#include "files/usage_error.h"

namespace firn {
namespace {

// Errors of the system that lie in the path that was named, not in the machine.
bool is_path_error(int error) {
  for (const int e :
       {ENOENT, ENOTDIR, EISDIR, EACCES, EPERM, ELOOP, ENAMETOOLONG, EEXIST, EINVAL, EROFS, ENOTEMPTY})
    if (error == e) return true;
  return false;
}

Failure failure(const std::exception& error) {
  if (dynamic_cast<const ConfigError*>(&error) || dynamic_cast<const UsageError*>(&error) ||
      dynamic_cast<const record::PackedError*>(&error))
    return {kUsage, error.what()};
  if (const auto* file = dynamic_cast<const record::FileError*>(&error))
    return {is_path_error(file->error) ? kUsage : kFailed, error.what()};
  // The library's own text has the name of its function and quotes.
  if (const auto* file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    std::string names = file->path1().string();
    if (!file->path2().empty()) names += " and " + file->path2().string();
    return {is_path_error(file->code().value()) ? kUsage : kFailed, names + ": " + file->code().message()};
  }
  if (dynamic_cast<const std::bad_alloc*>(&error)) return {kFailed, "needs more memory than there is"};
  if (const auto* json = dynamic_cast<const nlohmann::json::exception*>(&error))
    return {kFailed,
            "a text that is to be written or was read as JSON is damaged (" + std::to_string(json->id) + ")"};
  return {kFailed, error.what()};
}

}  // namespace

Failure failure_of(const std::exception& error) {
  Failure f = failure(error);
  while (!f.line.empty() && f.line.back() == '\n') f.line.pop_back();
  for (char& c : f.line)
    if (c == '\n' || c == '\r') c = ' ';
  return f;
}

}  // namespace firn
