// Any text as .lcm files, as an old log may carry them.
#include <stdexcept>

#include "lcmtypes/schema.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const firn::Schema schema = firn::Schema::parse({reinterpret_cast<const char*>(data), size});
    for (const auto& type : schema.types())
      for (const auto& field : type.fields) firn::fuzz::require(!field.path.empty(), "a field has a path");
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
