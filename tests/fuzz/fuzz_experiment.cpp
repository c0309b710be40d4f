// Any text as an experiment: an Experiment that dumps and reads back alike, or one ConfigError.
#include "config/error.h"
#include "config/experiment.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const std::string once = dump(parse_experiment(text, "fuzz.toml"));
    require(dump(parse_experiment(once, "dump.toml")) == once, "what is dumped reads back alike");
  } catch (const ConfigError&) {
  }
  return 0;
}
