#include "studies/compare/outline_metrics.h"

#include <cmath>
#include <string>

namespace firn {
namespace {

bool has_sign(const OutlineMetric& metric) { return metric.name.starts_with("size_"); }

}  // namespace

report::StudyMetric outline_metric_of(const OutlineMetric& m) {
  return {std::string(m.name), std::string(m.unit),
          (has_sign(m) ? "size of the " : "") + std::string(m.meaning), m.decimals};
}

double outline_value(const OutlineMetric& m, const OutlineStats& outline) {
  const double value = outline.*m.value * m.factor;
  return has_sign(m) ? std::abs(value) : value;
}

}  // namespace firn
