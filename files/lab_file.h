// with_keys changes keys in the text of a lab file and keeps the comments of the file.
#pragma once

#include <string>
#include <vector>

namespace firn {

struct LabKey {
  std::string section, key;  ///< "laser_point", "latency_s"
  std::string value;         ///< as TOML
  std::string comment;       ///< behind the value
};

/// Replaces keys in place (an array may span several lines). Adds missing keys at the end of their section,
/// and missing sections at the end of the file.
std::string with_keys(const std::string& toml_text, const std::vector<LabKey>& keys);

/// Returns the lines that differ, prefixed by "- " and "+ ", for files in which few lines change.
std::string changed_lines(const std::string& before, const std::string& after);

}  // namespace firn
