#include <fmt/core.h>

#include <cstdio>

#include "cli/runs_command.h"
#include "config/include.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/interrupt.h"
#include "print/progress.h"
#include "runs/find/use_sums.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;
using Of = runs::UseSum::Of;

Json use_json(const runs::UseSums& used, const std::vector<runs::UseWarning>& near) {
  Json all = Json::array(), warnings = Json::array();
  for (const runs::UseSum& s : used.sums)
    all.push_back({{"of", s.of == Of::kBatch ? "batch" : "instrument"},
                   {"name", s.name},
                   {"port", s.port},
                   {"runs", s.runs},
                   {"volume_mm3", s.volume_mm3},
                   {"hours", s.of == Of::kBatch ? Json(nullptr) : Json(s.hours)}});
  for (const runs::UseWarning& w : near)
    warnings.push_back({{"name", w.sum->name},
                        {"port", w.sum->port},
                        {"used", w.used},
                        {"limit", w.limit},
                        {"unit", w.unit}});
  return {{"use", all}, {"warnings", warnings}, {"unread_runs", used.unread}};
}

}  // namespace

int sum_runs_use(const RunsOptions& o) {
  if (o.words.size() > 2) throw UsageError("use: give one lab file or experiment, whose limits hold");
  const UseLimits limits = o.words.size() == 2 ? load_meta(o.words[1]).use : UseLimits{};
  JobProgress progress("reading");
  const InterruptGuard guard;
  const runs::UseSums used = runs::sum_use(
      {o.runs.begin(), o.runs.end()}, [&](double share) { progress.show(share, "runs"); },
      InterruptGuard::raised);
  if (InterruptGuard::raised()) return kInterrupted;
  progress.done();
  const auto near = runs::use_warnings(used, limits);
  if (o.json) {
    fmt::print("{}\n", use_json(used, near).dump(2, ' ', false, Json::error_handler_t::replace));
    return kOk;
  }
  for (const runs::UseSum& s : used.sums) {
    fmt::print("{} ({}): ", s.name, s.port);
    if (s.of == Of::kInstrument) fmt::print("{}, ", time_for_people(s.hours * kHour_s));
    if (s.volume_mm3 > 0.0 || s.of == Of::kBatch) fmt::print("{} mm^3, ", for_people(s.volume_mm3));
    fmt::print("{} run{}\n", s.runs, s.runs == 1 ? "" : "s");
  }
  if (used.sums.empty()) fmt::print("no run has used anything\n");
  for (const runs::UseWarning& w : near) fmt::print("warning: {}\n", w.words());
  if (used.unread > 0)
    fmt::print(stderr, "{} runs are not counted: they print, or their records cannot be read\n", used.unread);
  return kOk;
}

}  // namespace firn
