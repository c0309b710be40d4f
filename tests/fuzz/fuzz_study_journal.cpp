// Any text as the journal of a study and as the state of a search, its lines as they come or with true
// checksums: prints with each metric, or lines that do not count. Input: u8 choice, text.
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "files/record/checksum.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "studies/compare/study_journal.h"
#include "studies/tune/print_journal.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

std::string with_checksums(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    char hex[18];
    std::snprintf(hex, sizeof hex, "%016llx ",
                  static_cast<unsigned long long>(record::checksum64(std::as_bytes(std::span(line)))));
    out += hex + std::string(line) + "\n";
    at = end + 1;
  }
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  static const std::filesystem::path file = "/dev/shm/firn-fuzz-journal-" + std::to_string(::getpid());
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  const std::string whole = data[0] % 4 ? with_checksums(text) : std::string(text);
  std::FILE* out = std::fopen(file.c_str(), "wb");
  require(out && std::fwrite(whole.data(), 1, whole.size(), out) == whole.size(), "the journal is written");
  std::fclose(out);
  try {
    tune::PrintJournal prints(file);
    require(prints.known() + prints.damaged() <= size + 1, "a line is a simulated print or damaged");
    if (const auto p = prints.find("")) {
      prints.append("", *p);
      require(prints.find("").has_value(), "a simulated print that is written again is found");
    }
  } catch (const UsageError&) {
  }
  const StudyLab& lab = inkjet_study_lab();
  StudyJournal journal(file, lab.metrics);
  require(journal.size() + journal.damaged() <= size + 1, "a line is a print or damaged");
  if (const StudyPrint* p = journal.find("")) {
    require(p->metrics.size() == lab.metrics.size(), "a print has each metric");
    const std::size_t before = journal.size();
    journal.append("", "a", "b", 1, *p);
    require(journal.size() == before, "a print that is written again takes its own place");
  }
  return 0;
}
