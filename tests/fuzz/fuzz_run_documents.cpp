// Any text as a run's provenance or result: a document, or an error that names the file. The first byte
// chooses.
#include "runs/folder/documents.h"

#include <stdexcept>

#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    if (data[0] % 2) {
      const runs::ProvenanceDocument p = runs::parse_provenance(text, "fuzz.json");
      require(!p.run_id || *p.run_id >= 0, "a run's number is not negative");
      for (const auto& [role, sha] : p.inputs) require(sha.size() == 64, "a digest has 64 digits");
    } else {
      runs::parse_result(text, "fuzz.json");
    }
  } catch (const std::invalid_argument& e) {
    require(std::string_view(e.what()).starts_with("fuzz.json: "), "an error names the file");
  }
  return 0;
}
