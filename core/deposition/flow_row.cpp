#include "core/deposition/flow_row.h"

namespace firn::deposition {
namespace {

[[gnu::always_inline]] inline void flows(const double* __restrict hc, const double* __restrict hn,
                                         const double* __restrict uc, const double* __restrict un, double w,
                                         double slope, double* __restrict flow, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double x = slope * (hc[i] - hn[i]);
    double give = w + x, take = w - x;
    give = give < w ? give : w;
    take = take < w ? take : w;
    give = give > 0.0 ? give : 0.0;
    take = take > 0.0 ? take : 0.0;
    flow[i] = uc[i] * give - un[i] * take;
  }
}

[[gnu::always_inline]] inline void book(const double* __restrict flow, double* __restrict from, std::size_t n,
                                        double sign) {
  for (std::size_t i = 0; i < n; ++i) from[i] += sign * flow[i];
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void flow_row_avx2(const double* hc, const double* hn, const double* uc,
                                                   const double* un, double w, double slope, double* flow,
                                                   double* from, double* to, std::size_t n) {
  flows(hc, hn, uc, un, w, slope, flow, n);
  book(flow, from, n, -1.0);
  book(flow, to, n, 1.0);
}
#endif

}  // namespace

void flow_row_portable(const double* hc, const double* hn, const double* uc, const double* un, double w, double slope,
                       double* flow, double* from, double* to, std::size_t n) {
  flows(hc, hn, uc, un, w, slope, flow, n);
  book(flow, from, n, -1.0);
  book(flow, to, n, 1.0);
}

void flow_row(const double* hc, const double* hn, const double* uc, const double* un, double w, double slope,
              double* flow, double* from, double* to, std::size_t n) {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2");  // wider, not different: element by element, no FMA
  if (avx2) return flow_row_avx2(hc, hn, uc, un, w, slope, flow, from, to, n);
#endif
  flow_row_portable(hc, hn, uc, un, w, slope, flow, from, to, n);
}

}  // namespace firn::deposition
