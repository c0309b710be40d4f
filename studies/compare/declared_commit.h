// declared_commit finds the commit of a file that had to be written down before its results.
#pragma once

#include <filesystem>
#include <string>

namespace firn {

/// Returns the newest commit that changed the file, in words that say more where it does not hold: the file
/// has been changed since, is in no commit, or git does not answer. The text ends with the file's SHA-256,
/// which tells which contents these are without git.
std::string declared_commit(const std::filesystem::path& file);

}  // namespace firn
