#include "studies/tune/verify_promise.h"

#include <cmath>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "files/digest.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "studies/compare/study_lab.h"
#include "studies/compare/study_runner.h"

namespace firn::tune {
namespace {

constexpr std::uint32_t kVerifyStream = 5000;

void refuse_real(const RecordedRun& run) {
  if (run.noise == MapNoise::kFromMaps)
    throw UsageError(run.name +
                     ": --verify prints in a simulated lab, and this run is imported: print pairs " +
                     "where it comes from");
  for (const DevicePort& port : kDevicePorts)
    if (const std::string& address = run.experiment.devices.*port.member; !address.starts_with("sim:"))
      throw UsageError(run.name + ": --verify prints in a simulated lab, and devices." +
                       std::string(port.node) + " = \"" + address +
                       "\": print pairs with firn print --set and compare them");
}

}  // namespace

PromisePairs::PromisePairs(const RecordedRun& run, std::span<const TuneKey> keys,
                           const PairSettings& settings)
    : lab_(study_lab_of(run.experiment)) {
  refuse_real(run);
  name = "pairs";
  kinds = {"old setting", "new setting"};
  values = lab_.metrics;
  seeds.clear();
  for (int n = 0; n < settings.pairs; ++n) {
    const std::uint64_t seed =
        print_seed({settings.seed, Purpose::kInstance, kVerifyStream, 0, std::uint32_t(n)});
    seeds.push_back(seed == run.experiment.plant.seed ? seed + 1 : seed);
  }
  std::string of_setting[2];
  for (const int s : {0, 1}) {
    Experiment& e = experiments_[s] =
        with_setting(keys, s == 0 ? settings.old_setting : settings.new_setting, run.experiment);
    inputs_[s] = e.grid == run.experiment.grid ? run.inputs : make_inputs(full_product(), e, ".");
    lab_.set_seed(e, 0);
    of_setting[s] = digest_of(e, inputs_[s]);
  }
  for (std::size_t n = 0; n < seeds.size(); ++n)
    for (const std::size_t s : {0, 1}) {
      const std::string whole = of_setting[s] + "seed " + std::to_string(seeds[n]) + "\n";
      cells.push_back({s, 0, n, sha256_hex(std::as_bytes(std::span(whole)))});
    }
}

StudyPrint PromisePairs::make(const StudyCell& cell) const {
  Experiment e = experiments_[cell.arm];
  lab_.set_seed(e, seeds[cell.seed]);
  return lab_.print(e, inputs_[cell.arm], false);
}

Verification verification_of(const PromisePairs& work, const StudyJournal& journal, const Promise& promise,
                             std::size_t goal) {
  Verification v;
  std::vector<double> a, b;
  for (std::size_t n = 0; n < work.cells.size(); n += 2) {
    const StudyPrint &o = *journal.find(work.cells[n].digest), &w = *journal.find(work.cells[n + 1].digest);
    v.stopped_old += !o.finished;
    v.stopped_new += !w.finished;
    if (!o.finished || !w.finished || !std::isfinite(o.metrics[goal]) || !std::isfinite(w.metrics[goal]))
      continue;
    a.push_back(o.metrics[goal]);
    b.push_back(w.metrics[goal]);
  }
  if (a.empty()) return v;
  v.pairs = statistics::compare_pairs(a, b);
  v.held = v.stopped_new <= v.stopped_old && v.pairs.difference >= promise.gain_interval.low &&
           v.pairs.difference <= promise.gain_interval.high;
  return v;
}

}  // namespace firn::tune
