#include "core/control/mpc/layer/strip_kernel.h"

#include <algorithm>
#include <limits>

#include "core/grid/avx2.h"

namespace firn::control::mpc {
namespace {

// Eight lanes on every processor, element by element: the same bytes on all.
using Lanes = float __attribute__((vector_size(32)));
using Marks = std::int32_t __attribute__((vector_size(32)));
constexpr int kLanes = 8;
// As a macro, since a function that returns a vector has no fixed ABI without AVX.
#define FIRN_ABSOLUTE(v) Lanes(Marks(v) & (Marks{} + 0x7fffffff))
#define FIRN_COST(v) \
  (Plain ? FIRN_ABSOLUTE(v) : cost.absolute * FIRN_ABSOLUTE(v) + (cost.linear + cost.square * (v)) * (v))

// Forward pass: after column x, best[b][n] is the least cost up to column x with patterns b on x and n on x +
// 1, and choice[x][b][n] the pattern of x - 1 that gives it. columns[0] precedes the first.
template <int K, int R, bool Plain>
FIRN_INLINE double solve_body(const StripColumn<K, R>* columns, int nx, const CellCost& of_cell,
                              std::uint8_t* choice, float* last) {
  const CellCost cost = of_cell;
  constexpr int S = StripColumn<K, R>::S, N = (S * S + kLanes - 1) / kLanes;
  constexpr int repeats = S < kLanes ? kLanes / S : 1;  // patterns b in eight lanes
  union Costs {
    Lanes lanes[N];
    float at[N * kLanes];
  };
  Costs best = {};
  Costs sum[R] = {};
  double total = 0.0;
  Lanes old[S][(S + repeats - 1) / repeats] = {};
  for (int a = 0; a < S; ++a)
    for (int b = 0; b < S; ++b) best.at[a * S + b] = a == 0 ? columns[1].price[b] : kNever;
  for (int x = 0; x < nx; ++x, choice += S * S) {
    const StripColumn<K, R>& before = columns[x];
    const StripColumn<K, R>& own = columns[x + 1];
    const StripColumn<K, R>& after = columns[x + 2];
    for (int a = 0; a < S; ++a)
      for (int b = 0; b < S; b += repeats)
        for (int l = 0; l < kLanes; ++l)
          old[a][b / repeats][l] = best.at[a * S + (repeats == 1 ? b : (b + l / S) % S)];
    for (int r = 0; r < R; ++r)
      for (int b = 0; b < S; ++b) {
        const float e = own.error[r] + own.adds[1][r][b];
        for (int n = 0; n < S; ++n) sum[r].at[b * S + n] = e + after.adds[0][r][n];
      }
    float least = std::numeric_limits<float>::max();
    for (int c = 0; c < N; ++c) {
      Lanes here[R];
      for (int r = 0; r < R; ++r) here[r] = sum[r].lanes[c];
      const int b = c * kLanes / S;
      Lanes lowest = old[0][b / repeats];
      for (int r = 0; r < R; ++r) lowest += FIRN_COST(here[r] + before.adds[2][r][0]);
      Marks from = {};
      for (int a = 1; a < S; ++a) {
        Lanes sum_to = old[a][b / repeats];
        for (int r = 0; r < R; ++r) sum_to += FIRN_COST(here[r] + before.adds[2][r][a]);
        const Marks better = sum_to < lowest;
        lowest = better ? sum_to : lowest;
        from = better ? Marks{} + a : from;
      }
      best.lanes[c] = lowest;
      for (int l = 0; l < std::min(kLanes, S * S); ++l) {
        choice[c * kLanes + l] = std::uint8_t(from[l]);
        least = lowest[l] < least ? lowest[l] : least;
      }
    }
    total += double(least);
    for (int b = 0; b < S; ++b)  // sums stay small, so that single precision does
      for (int n = 0; n < S; ++n) best.at[b * S + n] = best.at[b * S + n] - least + after.price[n];
  }
  for (int b = 0; b < S; ++b) last[b] = best.at[b * S];
  return total;
}

template <int K, int R>
FIRN_INLINE double solve_either(const StripColumn<K, R>* columns, int nx, const CellCost& cost,
                                std::uint8_t* choice, float* last) {
  if (is_plain(cost)) return solve_body<K, R, true>(columns, nx, cost, choice, last);
  return solve_body<K, R, false>(columns, nx, cost, choice, last);
}

template <int K, int R>
double solve_portable(const StripColumn<K, R>* columns, int nx, const CellCost& cost, std::uint8_t* choice,
                      float* last) {
  return solve_either<K, R>(columns, nx, cost, choice, last);
}
#if defined(__x86_64__)
template <int K, int R>
__attribute__((target("avx2"))) double solve_avx2(const StripColumn<K, R>* columns, int nx,
                                                  const CellCost& cost, std::uint8_t* choice, float* last) {
  return solve_either<K, R>(columns, nx, cost, choice, last);
}
#endif

template <int K, int R>
double forward(const StripColumn<K, R>* columns, int nx, const CellCost& cost, std::uint8_t* choice,
               float* last) {
#if defined(__x86_64__)
  if (has_avx2()) return solve_avx2<K, R>(columns, nx, cost, choice, last);
#endif
  return solve_portable<K, R>(columns, nx, cost, choice, last);
}

}  // namespace

template <int K, int R>
double solve_strip(const StripColumn<K, R>* columns, int nx, const CellCost& cost, std::uint8_t* choice,
                   int* patterns) {
  constexpr int S = StripColumn<K, R>::S;
  float last[S];
  const double total = forward<K, R>(columns, nx, cost, choice, last);
  const float* best = std::min_element(last, last + S);
  patterns[nx - 1] = int(best - last);
  for (int x = nx - 1; x > 0; --x) {
    const int after = x + 1 < nx ? patterns[x + 1] : 0;
    patterns[x - 1] = choice[(std::size_t(x) * S + std::size_t(patterns[x])) * S + std::size_t(after)];
  }
  return total + double(*best);
}

#define FIRN_MAKE(K, R) \
  template double solve_strip<K, R>(const StripColumn<K, R>*, int, const CellCost&, std::uint8_t*, int*);
FIRN_MAKE(1, 3)
FIRN_MAKE(2, 4)
FIRN_MAKE(3, 5)
FIRN_MAKE(4, 6)
FIRN_MAKE(5, 7)
FIRN_MAKE(6, 8)

}  // namespace firn::control::mpc
