// Any text as a study: a study whose experiments resolve, or one ConfigError.
#include "config/error.h"
#include "config/study.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    Study s = parse_study({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
    require(!s.arms.empty() && s.arms.size() <= kMaxArms, "arms within their limit");
    require(!s.parts.empty() && !s.seeds.empty(), "a part and a seed");
    s.experiment.clear();  // no files here
    std::vector<Experiment> experiments = study_experiments(s, "");
    require(experiments.size() == s.arms.size() * s.parts.size(), "an experiment for each arm on each part");
    check_labs(s, experiments.front());
    draw_lab(s, s.seeds.front(), experiments.front());
  } catch (const ConfigError&) {
  }
  return 0;
}
