#include "cli/use_warning.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "config/devices.h"
#include "print/progress.h"
#include "runs/find/use_sums.h"

namespace firn {
namespace {

// The instrument and its port as the counters name them.
bool takes_part(const Experiment& e, const runs::UseSum& sum) {
  const auto simulated = simulated_ports(e);
  if (sum.port == "simulated") return std::ranges::find(simulated, sum.name) != simulated.end();
  return outside_ports(e).contains(sum.name) && port_text(e.devices, sum.name) == sum.port;
}

}  // namespace

void warn_of_use(const UseLimits& limits, const Meta& meta, const Experiment& e,
                 const std::string& runs_folder) {
  if (limits.limits.empty() || !std::filesystem::is_directory(runs_folder)) return;
  JobProgress progress("counting use");
  const runs::UseSums used =
      runs::sum_use({runs_folder}, [&](double share) { progress.show(share, "runs"); });
  progress.done();
  const bool real = !real_ports(e).empty();
  for (const runs::UseWarning& w : runs::use_warnings(used, limits)) {
    const bool of_batch = w.sum->of == runs::UseSum::Of::kBatch;
    if (of_batch ? w.sum->name == runs::batch_name(meta) && (w.sum->port == "real") == real
                 : takes_part(e, *w.sum))
      fmt::print(stderr, "warning: {}: the end of [lab.use] is near\n", w.words());
  }
}

}  // namespace firn
