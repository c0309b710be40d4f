#include "core/statistics/leave_one_out.h"

#include <cmath>
#include <stdexcept>

#include "core/statistics/distributions.h"

namespace firn::statistics {

LeftOneOut leave_one_out(std::span<const double> without) {
  const double n = double(without.size());
  if (n < 2.0) throw std::invalid_argument("leave_one_out: two groups at least are needed");
  LeftOneOut r;
  for (const double x : without) r.mean += x / n;
  double squares = 0.0;
  for (const double x : without) squares += (x - r.mean) * (x - r.mean);
  r.half_width = student_t_95(n - 1.0) * std::sqrt((n - 1.0) / n * squares);
  return r;
}

}  // namespace firn::statistics
