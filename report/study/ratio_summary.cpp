#include "report/study/ratio_summary.h"

#include <cmath>

#include "core/statistics/sign_flip.h"

namespace firn::report {

RatioSummary ratio_of(std::span<const double> logs, const statistics::BootstrapOptions& options) {
  RatioSummary s;
  s.pairs = logs.size();
  s.ratio = std::exp(statistics::mean(logs));
  const statistics::Interval both = statistics::bootstrap_interval(logs, options);
  s.interval = {std::exp(both.low), std::exp(both.high)};
  s.p = statistics::sign_flip_p(logs);
  statistics::BootstrapOptions one_sided = options;
  one_sided.confidence = 1.0 - 2.0 * (1.0 - options.confidence);
  s.upper = std::exp(statistics::bootstrap_interval(logs, one_sided).high);
  return s;
}

}  // namespace firn::report
