// Any text as a study, whose experiments resolve, and as a declaration of worlds, or one ConfigError each.
#include "config/error.h"
#include "config/study_labs.h"
#include "config/worlds.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const WorldList w = parse_worlds({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
    require(!w.worlds.empty() && !w.metrics.empty() && !w.seeds[1].empty(),
            "worlds, metrics and labs to judge in");
    for (const DeclaredWorld& world : w.worlds) require(!world.priors[1].empty(), "labs of each world");
  } catch (const ConfigError&) {
  }
  try {
    Study s = parse_study({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
    require(!s.arms.empty() && s.arms.size() <= kMaxArms, "arms within their limit");
    if (!s.worlds.file.empty()) return 0;  // its parts and seeds are in another file
    require(!s.parts.empty() && !s.seeds.empty(), "a part and a seed");
    s.experiment.clear();  // no files here
    std::vector<Experiment> experiments = study_experiments(s, "");
    require(experiments.size() == s.arms.size() * s.parts.size(), "an experiment for each arm on each part");
    check_labs(s, 0, experiments.front());
    draw_lab(s, 0, s.seeds.front(), experiments.front());
  } catch (const ConfigError&) {
  }
  return 0;
}
