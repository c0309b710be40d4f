#include "runs/find/use_sums.h"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "core/options/for_people.h"
#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/documents.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_meta.h"
#include "runs/read/print_use.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr double kPercent = 100.0;

struct UsedRun {
  std::int64_t run_id = 0;
  Meta meta;
  std::optional<PrintUse> use;
};

UsedRun used_run(const fs::path& run) try {
  const RunPaths paths(run);
  const ProvenanceDocument provenance =
      parse_provenance(read_file(paths.provenance_path()), paths.provenance_path().string());
  UsedRun r{provenance.run_id.value_or(0), run_meta(provenance).values, {}};
  if (fs::exists(paths.result_path()))
    r.use = parse_result(read_file(paths.result_path()), paths.result_path().string()).use;
  if (!r.use) r.use = print_use(run);
  return r;
} catch (const std::exception&) {
  return {};
}

std::vector<fs::path> runs_in(const std::vector<fs::path>& places) {
  std::vector<fs::path> all;
  for (const fs::path& place : places) {
    if (!fs::is_directory(place)) throw UsageError(place.string() + ": no such folder");
    if (is_run(place)) {
      all.push_back(place);
      continue;
    }
    for (const auto& entry : fs::directory_iterator(place))
      if (is_run(entry.path())) all.push_back(entry.path());
  }
  return all;
}

using Counters = std::map<std::tuple<UseSum::Of, std::string, std::string>, UseSum>;

UseSum& counter(Counters& counters, UseSum::Of of, const std::string& name, const std::string& port) {
  UseSum& sum = counters[{of, name, port}];
  sum.of = of;
  sum.name = name;
  sum.port = port;
  ++sum.runs;
  return sum;
}

void add(const UsedRun& run, Counters& counters) {
  for (const auto& [node, i] : run.use->instruments) {
    if (i.hours == 0.0 && i.volume_mm3 == 0.0) continue;
    UseSum& sum = counter(counters, UseSum::Of::kInstrument, node, i.port);
    sum.hours += i.hours;
    sum.volume_mm3 += i.volume_mm3;
    const std::string batch = batch_name(run.meta);
    if (node == run.use->depositing && !batch.empty())
      counter(counters, UseSum::Of::kBatch, batch, i.port == "simulated" ? i.port : "real").volume_mm3 +=
          i.volume_mm3;
  }
}

}  // namespace

std::string batch_name(const Meta& meta) {
  const std::string ink = meta_text(meta, "ink"), batch = meta_text(meta, "batch");
  if (ink.empty()) return batch.empty() ? "" : "batch " + batch;
  return "ink " + ink + (batch.empty() ? "" : ", batch " + batch);
}

UseSums sum_use(const std::vector<fs::path>& places, const std::function<void(double)>& progress,
                const std::function<bool()>& interrupted) {
  const std::vector<fs::path> all = runs_in(places);
  Counters counters;
  UseSums sums;
  std::set<std::int64_t> seen;
  std::size_t done = 0;
  for (const fs::path& folder : all) {
    if (interrupted && interrupted()) break;
    if (progress) progress(double(done++) / double(all.size()));
    const UsedRun run = used_run(folder);
    if (run.run_id != 0 && !seen.insert(run.run_id).second) continue;
    if (run.use)
      add(run, counters);
    else
      ++sums.unread;
  }
  for (auto& [key, sum] : counters) sums.sums.push_back(std::move(sum));
  return sums;
}

std::string UseWarning::words() const {
  return fmt::format("{} ({}): {} of {} {} ({:.0f} %)", sum->name, sum->port, for_people(used),
                     for_people(limit), unit, std::floor(kPercent * used / limit));
}

std::vector<UseWarning> use_warnings(const UseSums& sums, const UseLimits& limits) {
  std::vector<UseWarning> warnings;
  for (const UseSum& sum : sums.sums)
    for (const UseLimit& l : limits.limits) {
      const bool batch = sum.of == UseSum::Of::kBatch;
      if (l.key != (batch ? "batch_mm3" : sum.name + "_h")) continue;
      const double used = batch ? sum.volume_mm3 : sum.hours;
      if (used * kPercent >= l.limit * limits.warn_percent)
        warnings.push_back({&sum, used, l.limit, batch ? "mm^3" : "h"});
    }
  return warnings;
}

}  // namespace firn::runs
