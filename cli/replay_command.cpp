#include "cli/replay_command.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "cli/exit_codes.h"
#include "cli/node_makers.h"
#include "cli/run_config.h"
#include "replay/print_verdict.h"
#include "replay/replayer.h"
#include "runtime/build_info.h"

namespace firn {

int run_replay(const ReplayCommandOptions& options) {
  replay::ReplayOptions r;
  std::vector<replay::NodeMaker> makers;
  for (const NamedMaker& m : node_makers()) makers.push_back({info(m.id).name, m.make});
  r.makers = makers;
  r.only_node = options.node;
  r.tolerance = options.tolerance;
  r.threads = options.threads;
  r.commit = build_commit();
  r.platform = platform_description();
  if (!std::isfinite(options.tolerance) || options.tolerance < 0)
    throw UsageError("--tolerance: a finite number >= 0 is wanted");
  replay::RunVerdict verdict;
  try {
    for (const std::string& text : options.ignores) r.ignores.push_back(replay::parse_ignore(text));
    const ConfigChange config = config_change(options.run, recorded_config(options.run), options.overrides);
    r.change_config = config.change;
    verdict = replay::replay_run(options.run, r);
    verdict.changed_settings = config.settings;
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
  std::fputs(options.json ? (replay::to_json(verdict) + "\n").c_str() : replay::to_text(verdict).c_str(), stdout);
  return verdict.exit_status();
}

}  // namespace firn
