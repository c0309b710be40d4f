#include "studies/tune/verify_promise.h"

#include <cmath>
#include <mutex>
#include <vector>

#include "core/grid/random.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "studies/compare/study_lab.h"
#include "studies/identify/identification_study.h"

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

Verification verify_promise(const RecordedRun& run, std::span<const TuneKey> keys, const Advice& advice,
                            const VerifyOptions& options) {
  refuse_real(run);
  const Experiment settings[2] = {with_setting(keys, advice.old_setting, run.experiment),
                                  with_setting(keys, advice.new_setting, run.experiment)};
  const auto inputs_of = [&](const Experiment& e) {
    return e.grid == run.experiment.grid ? run.inputs : make_inputs(full_product(), e, ".");
  };
  const Blobs inputs[2] = {inputs_of(settings[0]), inputs_of(settings[1])};
  const StudyLab& lab = study_lab_of(run.experiment);
  std::vector<StudyPrint> prints(std::size_t(2 * options.prints));
  std::mutex lock;
  int done = 0;
  run_jobs(2 * options.prints, options.threads, [&](int n) {
    Experiment e = settings[n % 2];
    const std::uint64_t seed =
        print_seed({options.seed, Purpose::kInstance, kVerifyStream, 0, std::uint32_t(n / 2)});
    lab.set_seed(e, seed == run.experiment.plant.seed ? seed + 1 : seed);
    prints[std::size_t(n)] = lab.print(e, inputs[n % 2]);
    const std::lock_guard hold(lock);
    if (options.progress) options.progress(double(++done) / double(2 * options.prints), "verifying");
  });
  Verification v;
  std::vector<double> a, b;
  for (int n = 0; n < options.prints; ++n) {
    const StudyPrint &o = prints[std::size_t(2 * n)], &w = prints[std::size_t(2 * n + 1)];
    v.stopped_old += !o.finished;
    v.stopped_new += !w.finished;
    if (!o.finished || !w.finished || !std::isfinite(o.metrics[options.goal]) ||
        !std::isfinite(w.metrics[options.goal]))
      continue;
    a.push_back(o.metrics[options.goal]);
    b.push_back(w.metrics[options.goal]);
  }
  if (a.empty()) return v;
  v.pairs = statistics::compare_pairs(a, b);
  const auto& promised = advice.promise.gain_interval;
  v.held = v.stopped_new <= v.stopped_old && v.pairs.difference >= promised.low &&
           v.pairs.difference <= promised.high;
  return v;
}

}  // namespace firn::tune
