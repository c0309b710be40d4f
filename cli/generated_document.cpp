#include "cli/generated_document.h"

#include <cstdio>

#include "files/json.h"
#include "runs/folder/run_folder.h"

namespace firn {

void write_generated(const std::string& output, const std::string& text, bool json) {
  if (output == "-") {
    std::fputs((json ? nlohmann::json(text).dump() + "\n" : text).c_str(), stdout);
    return;
  }
  write_file_atomically(output, text);
  if (json)
    std::fputs((nlohmann::json{{"written", output}, {"bytes", text.size()}}.dump() + "\n").c_str(), stdout);
  else
    std::fprintf(stderr, "wrote %s\n", output.c_str());
}

}  // namespace firn
