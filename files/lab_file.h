// Keys of a lab file changed in its text, so that its comments stay.
#pragma once

#include <string>
#include <vector>

namespace firn {

struct LabKey {
  std::string section, key;  ///< "laser_point", "latency_s"
  std::string value;         ///< as TOML
  std::string comment;       ///< behind it
};

/// Replaces the keys where they stand (an array may go over several lines), adds those that are missing at
/// the end of their section, and sections that are missing at the end of the file.
std::string with_keys(const std::string& toml_text, const std::vector<LabKey>& keys);

/// The lines that differ, "- " and "+ " before them: enough for a file in which few lines change.
std::string changed_lines(const std::string& before, const std::string& after);

}  // namespace firn
