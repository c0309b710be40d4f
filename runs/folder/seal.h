// Seal holds length and SHA-256 of every file of a folder at one moment, and the digest of the seal before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn::runs {

struct SealedFile {
  std::string path;  ///< relative to the folder, with '/'
  std::uint64_t bytes = 0;
  std::string sha256;
  /// The file does not begin with the content that the seal before has of it; digests of earlier seals do not
  /// hold any more.
  bool anew = false;
};

struct Seal {
  std::int64_t number = 0;  ///< 0, 1, 2, …
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  bool open = false;                 ///< made when the incarnation began; else when it ended
  std::string reason;                ///< one line
  std::string before;                ///< digest of the seal before; empty: the first
  std::vector<std::string> differs;  ///< one line each: differences from the seals before, found by this one
  std::vector<SealedFile> files;     ///< by path
  std::string digest;                ///< of all lines before the last
};

/// Returns the seal as lines of text; the last line is the digest of all lines before. Fills `digest`.
std::string encode_seal(Seal& seal);
/// @throws std::runtime_error naming line and reason: another digest, another form, a path out of the folder.
Seal decode_seal(std::string_view text);

struct FileDigests {
  std::uint64_t bytes = 0;
  std::string sha256;
  std::vector<std::string> prefixes;  ///< of each asked length; empty: the file is shorter
};

/// Computes the digests of a regular file; a symbolic link is not followed.
/// @param lengths of prefixes, ascending
/// @param sync fdatasync the file first
/// @throws std::runtime_error naming path and the system's reason
FileDigests digest_file(const std::filesystem::path& path, std::span<const std::uint64_t> lengths,
                        bool sync = false);

/// Returns true if the first bytes of `path` followed by all bytes of `tail` are the sealed content: the rest
/// of a torn write was moved there.
bool restores(const std::filesystem::path& path, const std::filesystem::path& tail, const SealedFile& sealed);

}  // namespace firn::runs
