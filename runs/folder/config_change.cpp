#include "runs/folder/config_change.h"

#include <algorithm>
#include <utility>

#include "config/changes.h"
#include "config/experiment.h"
#include "config/include.h"
#include "files/run_paths.h"
#include "runs/folder/recorded_steps.h"

namespace firn::runs {

namespace fs = std::filesystem;

ConfigChange config_change(const fs::path& run, const std::string& recorded_toml,
                           const std::vector<std::string>& overrides) {
  ConfigChange result;
  if (recorded_toml.empty()) return result;
  const std::string name = "the recorded configuration";
  const Experiment recorded = parse_recorded_experiment(recorded_toml, name);
  const fs::path file = RunPaths(run).experiment_path();
  const Experiment now = fs::exists(file)
                             ? parse_recorded_experiment(read_config_text(file), file.string(), overrides)
                             : parse_recorded_experiment(recorded_toml, name, overrides);
  for (const ConfigDifference& d : differences(recorded, now)) {
    result.settings.push_back(d.key + ": recorded " + d.a + ", now " + d.b);
    if (const std::string unread = unread_by_scheme(now, d.key); !unread.empty())
      result.unread.push_back(d.key + " " + unread);
  }
  // Nodes take today's default for a key that an earlier version's text lacks.
  if (!result.settings.empty() || dump(recorded) != recorded_toml)
    result.change = [text = dump(now)](const std::string&) { return text; };
  return result;
}

std::string recorded_config(const fs::path& run) {
  for (const fs::path& path : RunPaths(run).wal_files()) {
    try {
      if (auto head = runs::first_head(path)) return std::move(head->config_toml);
    } catch (const std::exception&) {
      // replay names a file that cannot be read
    }
  }
  return "";
}

}  // namespace firn::runs
