#include "cli/text_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace firn {

void write_whole(const std::filesystem::path& path, std::string_view text) {
  const std::string temporary = path.string() + ".part";
  const auto fail = [&](const char* what) {
    const int error = errno;
    std::remove(temporary.c_str());
    throw std::runtime_error(path.string() + ": " + what + ": " + std::strerror(error));
  };
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) fail("cannot be written");
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (std::fclose(file) != 0 || !written) fail("cannot be written");
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail("cannot be replaced");
}

void write_generated(const std::string& output, const std::string& text, bool json) {
  if (output == "-") {
    std::fputs((json ? nlohmann::json(text).dump() + "\n" : text).c_str(), stdout);
    return;
  }
  write_whole(output, text);
  if (json)
    std::fputs((nlohmann::json{{"written", output}, {"bytes", text.size()}}.dump() + "\n").c_str(), stdout);
  else
    std::fprintf(stderr, "wrote %s\n", output.c_str());
}

}  // namespace firn
