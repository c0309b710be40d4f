#include "config/error.h"

namespace firn {
namespace {

std::string compose(const std::string& file, int line, const std::string& problem) {
  return file + (line > 0 ? ":" + std::to_string(line) : "") + ": " + problem;
}

}  // namespace

ConfigError::ConfigError(const std::string& file_name, int line_number, const std::string& key_name,
                         const std::string& what_is_wrong)
    : std::runtime_error(compose(file_name, line_number, what_is_wrong)),
      file(file_name),
      line(line_number),
      key(key_name),
      problem(what_is_wrong) {}

}  // namespace firn
