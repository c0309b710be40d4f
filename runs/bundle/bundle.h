// A bundle is runs in one .eln file: a ZIP archive with RO-Crate metadata, as electronic laboratory notebooks
// exchange their entries. https://github.com/TheELNConsortium/TheELNFileFormat, https://w3id.org/ro/crate/1.1
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace firn::runs {

inline constexpr const char* kCrateMetadata = "ro-crate-metadata.json";

struct BundleReport {
  std::size_t files = 0;
  std::uint64_t bytes = 0;  ///< of the files
};

/// Writes runs and their metadata into `file`. Notes that no seal covers yet are not sealed by it.
/// @param license of the data, its address or its name @param progress receives the fraction of all bytes
/// @throws UsageError: a run that is not as it was sealed, prints or is in use, two runs of one name, a file
/// that cannot be written; WriteError
BundleReport write_bundle(const std::vector<std::filesystem::path>& runs, const std::filesystem::path& file,
                          const std::string& license = "", const std::function<void(double)>& progress = {});

/// A run of a bundle, unpacked.
struct BundledRun {
  std::string name;
  std::filesystem::path folder;
};

/// Unpacks a bundle into a folder and compares each file with the size and the SHA-256 of its metadata.
///
/// A bundle may come from anybody: before a byte is written every name, kind and size is looked at. Links,
/// paths that leave the folder, two files of one name, encrypted files, and archives that unpack to more than
/// 64 MiB + 200 times their size are refused by name.
/// @param into an empty folder @returns its runs, in the order of their names
/// @throws UsageError naming the file of the bundle and the reason
std::vector<BundledRun> unpack_bundle(const std::filesystem::path& file, const std::filesystem::path& into);

}  // namespace firn::runs
