// Crate writes the RO-Crate metadata of a bundle: flattened JSON-LD in which each file has its name, its
// format, its size and its SHA-256.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace firn::runs {

struct CrateFile {
  std::string path;  ///< in the run, "nodes/stage.wal"
  std::uint64_t bytes = 0;
  std::string sha256;
};

struct CrateRun {
  std::filesystem::path folder;
  std::string name;
  std::vector<CrateFile> files;
};

/// Returns a path as a relative reference of a URI: "a b" as "a%20b" [RFC 3986].
std::string uri_path(std::string_view path);

/// @param created_utc moment of the bundle @param license of the data, its address or its name; empty: not
/// stated
std::string crate_metadata(const std::string& name, const std::vector<CrateRun>& runs,
                           const std::string& created_utc, const std::string& license);

}  // namespace firn::runs
