// firn_says runs one command of firn in this process, as main() does, and returns its output.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace firn::test {

inline const std::string kInkjet = FIRN_SOURCE_DIR "/labs/inkjet-lu2015.toml";
inline const std::string kAerosol = FIRN_SOURCE_DIR "/labs/aerosol-printer.toml";
inline const std::string kIce = FIRN_SOURCE_DIR "/labs/ice-cobra600.toml";

struct Said {
  int code = 0;
  std::string out, err;  ///< stdout; stderr, with the message of an error
};

/// @param words after "firn"
Said firn_says(const std::vector<std::string>& words);

/// A copy of a golden run in a fresh folder of that name, to be damaged.
std::filesystem::path golden_copy(const std::string& golden, const std::string& name);
std::filesystem::path golden(const std::string& name);
/// A fresh folder for a test's files.
std::filesystem::path fresh_folder(const std::string& name);

std::string file_text(const std::filesystem::path& file);
void write_file_text(const std::filesystem::path& file, const std::string& text);

}  // namespace firn::test
