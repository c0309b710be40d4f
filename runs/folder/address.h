// RunAddress names one run folder among all: by the number of its run and by its place. A folder's name alone
// names several where two prints began in one second, or where an archive holds a copy.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace firn::runs {

struct RunAddress {
  std::int64_t run_id = 0;  ///< 0: its provenance.json has none that can be read
  std::string place;        ///< 12 hexadecimal digits of the SHA-256 of the folder's path

  /// Returns "1764372000000000@3f0c66a1b2d4".
  std::string text() const;
  bool operator==(const RunAddress&) const = default;
};

RunAddress address_of(const std::filesystem::path& run);
/// Returns nothing: the text is no address.
std::optional<RunAddress> parse_address(std::string_view text);
/// Returns the place's digits of a folder.
std::string place_of(const std::filesystem::path& run);

/// Returns the folder that a user means: `text` if there is such a path, else the run in `root` that has this
/// address or this number. @throws UsageError: several have it, which are named, or none
std::filesystem::path folder_of(const std::string& text, const std::filesystem::path& root = "runs");

}  // namespace firn::runs
