#include "core/deposition/row_kernels.h"

#include "core/grid/avx2.h"

namespace firn::deposition {
namespace {

// uc clamp(w + x, 0, w) - un clamp(w - x, 0, w), x = slope (hc - hn)
FIRN_INLINE double net(double hc, double hn, double uc, double un, double w, double slope) {
  const double x = slope * (hc - hn);
  double give = w + x, take = w - x;
  give = give < w ? give : w;
  take = take < w ? take : w;
  give = give > 0.0 ? give : 0.0;
  take = take > 0.0 ? take : 0.0;
  return uc * give - un * take;
}

FIRN_INLINE void flow_apart(const double* __restrict hc, const double* __restrict hn,
                            const double* __restrict uc, const double* __restrict un, double w, double slope,
                            double* __restrict from, double* __restrict to, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const double f = net(hc[i], hn[i], uc[i], un[i], w, slope);
    from[i] -= f;
    to[i] += f;
  }
}

FIRN_INLINE void flow_overlapping(const double* __restrict hc, const double* __restrict hn,
                                  const double* __restrict uc, const double* __restrict un, double w,
                                  double slope, double* __restrict flow, double* __restrict from,
                                  std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    flow[i] = net(hc[i], hn[i], uc[i], un[i], w, slope);
    from[i] -= flow[i];
  }
}

FIRN_INLINE void add(const double* __restrict flow, double* __restrict to, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) to[i] += flow[i];
}

FIRN_INLINE void flow_body(const double* hc, const double* hn, const double* uc, const double* un, double w,
                           double slope, double* flow, double* from, double* to, std::size_t n) {
  if (to >= from + n || from >= to + n) {
    flow_apart(hc, hn, uc, un, w, slope, from, to, n);
    return;
  }
  flow_overlapping(hc, hn, uc, un, w, slope, flow, from, n);
  add(flow, to, n);
}

FIRN_INLINE std::int64_t load_body(const std::uint8_t* __restrict drops, int pass, double* __restrict u,
                                   std::size_t n) {
  std::int32_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t hit = drops[i] > pass ? 1 : 0;
    u[i] = hit;
    count += hit;
  }
  return count;
}

FIRN_INLINE void settle_body(double* __restrict h, const double* __restrict u, double drop_mm,
                             double* __restrict change, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    h[i] += u[i] * drop_mm + change[i];
    change[i] = 0.0;
  }
}

// The same three functions for an instruction set.
#define FIRN_KERNELS(suffix, attribute)                                                                 \
  attribute void flow_##suffix(const double* hc, const double* hn, const double* uc, const double* un,  \
                               double w, double slope, double* flow, double* from, double* to,          \
                               std::size_t n) {                                                         \
    flow_body(hc, hn, uc, un, w, slope, flow, from, to, n);                                             \
  }                                                                                                     \
  attribute std::int64_t load_##suffix(const std::uint8_t* drops, int pass, double* u, std::size_t n) { \
    return load_body(drops, pass, u, n);                                                                \
  }                                                                                                     \
  attribute void settle_##suffix(double* h, const double* u, double drop_mm, double* change,            \
                                 std::size_t n) {                                                       \
    settle_body(h, u, drop_mm, change, n);                                                              \
  }                                                                                                     \
  constexpr RowKernels k_##suffix{&flow_##suffix, &load_##suffix, &settle_##suffix};

FIRN_KERNELS(portable, )
#if defined(__x86_64__)
FIRN_KERNELS(avx2, __attribute__((target("avx2"))))
#endif

}  // namespace

const RowKernels& portable_row_kernels() { return k_portable; }

const RowKernels& row_kernels() {
#if defined(__x86_64__)
  if (has_avx2()) return k_avx2;
#endif
  return k_portable;
}

}  // namespace firn::deposition
