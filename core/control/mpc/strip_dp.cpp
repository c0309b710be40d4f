#include "core/control/mpc/strip_dp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn::control::mpc {
namespace {

constexpr float kNever = 1e30f;
constexpr double kLeastGainPerCell_mm = 1e-9;

#define FIRN_INLINE [[gnu::always_inline]] inline

// What the patterns of a column's cells in the strip add to the rows of the column before (0), of their own (1) and of
// the next one (2).
template <int K>
struct Column {
  static constexpr int S = 1 << K;  // patterns
  static constexpr int R = K + 2;   // rows that they reach
  float error[R];                   // with the strip empty
  float adds[3][R][S];
  float allowed[S];                 // 0, or kNever for a droplet where none may be
  int present;                      // pattern before
};

// Eight lanes, whatever the processor has: element by element, so the same bytes on any.
using Lanes = float __attribute__((vector_size(32)));
using Marks = std::int32_t __attribute__((vector_size(32)));
constexpr int kLanes = 8;
// As a macro, since a function that returns a vector has no fixed ABI without AVX.
#define FIRN_ABSOLUTE(v) Lanes(Marks(v) & (Marks{} + 0x7fffffff))

// Forward pass: after column x, best[b][n] is the least cost up to column x with patterns b on x and n on x + 1, and
// choice[x][b][n] the pattern of x - 1 that gives it. columns[0] stands before the first.
template <int K>
FIRN_INLINE void solve_body(const Column<K>* columns, int nx, std::uint8_t* choice, float* last) {
  constexpr int S = Column<K>::S, R = Column<K>::R, N = (S * S + kLanes - 1) / kLanes;
  constexpr int repeats = S < kLanes ? kLanes / S : 1;  // patterns b in eight lanes
  union {
    Lanes lanes[N];
    float at[N * kLanes];
  } best, sum[R];
  Lanes old[S][(S + repeats - 1) / repeats] = {};
  for (int a = 0; a < S; ++a)
    for (int b = 0; b < S; ++b) best.at[a * S + b] = a == 0 ? columns[1].allowed[b] : kNever;
  for (int x = 0; x < nx; ++x, choice += S * S) {
    const Column<K>& before = columns[x];
    const Column<K>& own = columns[x + 1];
    const Column<K>& after = columns[x + 2];
    for (int a = 0; a < S; ++a)
      for (int b = 0; b < S; b += repeats)
        for (int l = 0; l < kLanes; ++l) old[a][b / repeats][l] = best.at[a * S + (repeats == 1 ? b : (b + l / S) % S)];
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
      for (int r = 0; r < R; ++r) lowest += FIRN_ABSOLUTE(here[r] + before.adds[2][r][0]);
      Marks from = {};
      for (int a = 1; a < S; ++a) {
        Lanes cost = old[a][b / repeats];
        for (int r = 0; r < R; ++r) cost += FIRN_ABSOLUTE(here[r] + before.adds[2][r][a]);
        const Marks better = cost < lowest;
        lowest = better ? cost : lowest;
        from = better ? Marks{} + a : from;
      }
      best.lanes[c] = lowest;
      for (int l = 0; l < std::min(kLanes, S * S); ++l) {
        choice[c * kLanes + l] = std::uint8_t(from[l]);
        least = lowest[l] < least ? lowest[l] : least;
      }
    }
    for (int b = 0; b < S; ++b)  // sums stay small, so that single precision does
      for (int n = 0; n < S; ++n) best.at[b * S + n] = best.at[b * S + n] - least + after.allowed[n];
  }
  for (int b = 0; b < S; ++b) last[b] = best.at[b * S];
}

template <int K>
void solve_portable(const Column<K>* columns, int nx, std::uint8_t* choice, float* last) {
  solve_body<K>(columns, nx, choice, last);
}
#if defined(__x86_64__)
template <int K>
__attribute__((target("avx2"))) void solve_avx2(const Column<K>* columns, int nx, std::uint8_t* choice, float* last) {
  solve_body<K>(columns, nx, choice, last);
}
#endif

// Element by element, so the same bytes whichever instruction set runs it.
template <int K>
void solve(const Column<K>* columns, int nx, std::uint8_t* choice, float* last) {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2");
  if (avx2) return solve_avx2<K>(columns, nx, choice, last);
#endif
  solve_portable<K>(columns, nx, choice, last);
}

// The best droplets of rows [first, first + K) of all columns, everything else fixed.
template <int K>
class Strip {
 public:
  static constexpr int S = Column<K>::S, R = Column<K>::R;
  explicit Strip(int nx)
      : columns_(std::size_t(nx) + 2), effects_(std::size_t(nx) * 9 * K), choice_(std::size_t(nx) * S * S), pattern_(std::size_t(nx)) {}

  // @returns whether the objective fell; the problem has the better droplets then.
  bool improve(LayerProblem& problem, int first) {
    load(problem, first);
    float last[S];
    solve<K>(columns_.data(), problem.nx(), choice_.data(), last);
    pattern_.back() = int(std::min_element(last, last + S) - last);
    trace_back();
    return apply(problem, first);
  }

 private:
  void load(const LayerProblem& problem, int first);
  void trace_back();
  bool apply(LayerProblem& problem, int first);

  std::vector<Column<K>> columns_;     // one empty column at each end
  std::vector<float> effects_;         // of the strip's rows
  std::vector<std::uint8_t> choice_;   // best pattern of column x - 1 for those of x and x + 1
  std::vector<int> pattern_;
};

template <int K>
void Strip<K>::load(const LayerProblem& problem, int first) {
  const int nx = problem.nx();
  for (int b = 0; b < K; ++b) problem.effects(first + b, effects_.data() + std::size_t(b) * 9 * std::size_t(nx));
  for (int x = 0; x < nx; ++x) {
    Column<K>& c = columns_[std::size_t(x) + 1];
    c.present = 0;
    int barred = 0;
    for (int b = 0; b < K; ++b) {
      c.present |= int(problem.drop(x, first + b)) << b;
      barred |= int(!problem.printable(x, first + b)) << b;
    }
    for (int r = 0; r < R; ++r) c.error[r] = problem.error_row(first - 1 + r)[x];
    for (int s = 0; s < S; ++s) c.allowed[s] = s & barred ? kNever : 0.0f;
    for (int side = 0; side < 3; ++side)
      for (int r = 0; r < R; ++r) {
        c.adds[side][r][0] = 0.0f;
        for (int b = 0; b < K; ++b) {
          const int dy = r - 1 - b;
          const float f = dy < -1 || dy > 1 ? 0.0f : effects_[std::size_t((b * 9 + (dy + 1) * 3 + side) * nx + x)];
          for (int s = 0; s < 1 << b; ++s) c.adds[side][r][s | 1 << b] = c.adds[side][r][s] + f;
        }
      }
  }
  for (Column<K>* edge : {&columns_.front(), &columns_.back()}) {
    *edge = {};
    for (int s = 1; s < S; ++s) edge->allowed[s] = kNever;
  }
  for (int x = 0; x < nx; ++x) {  // errors with the strip empty
    Column<K>* c = &columns_[std::size_t(x) + 1];
    for (int r = 0; r < R; ++r)
      c->error[r] -= c[-1].adds[2][r][c[-1].present] + c->adds[1][r][c->present] + c[1].adds[0][r][c[1].present];
  }
}

template <int K>
void Strip<K>::trace_back() {
  const int nx = int(pattern_.size());
  for (int x = nx - 1; x > 0; --x) {
    const int after = x + 1 < nx ? pattern_[std::size_t(x) + 1] : 0;
    pattern_[std::size_t(x) - 1] = choice_[(std::size_t(x) * S + std::size_t(pattern_[std::size_t(x)])) * S + std::size_t(after)];
  }
}

template <int K>
bool Strip<K>::apply(LayerProblem& problem, int first) {
  const int nx = int(pattern_.size());
  double gain = 0.0;
  bool differs = false;
  const auto pattern = [&](int x) { return x < 0 || x >= nx ? 0 : pattern_[std::size_t(x)]; };
  for (int x = 0; x < nx; ++x) {
    const Column<K>* c = &columns_[std::size_t(x) + 1];
    differs = differs || pattern(x) != c->present;
    for (int r = 0; r < R; ++r) {
      const double before = double(c->error[r]) + c[-1].adds[2][r][c[-1].present] + c->adds[1][r][c->present] + c[1].adds[0][r][c[1].present];
      const double after = double(c->error[r]) + c[-1].adds[2][r][pattern(x - 1)] + c->adds[1][r][pattern(x)] + c[1].adds[0][r][pattern(x + 1)];
      gain += std::abs(before) - std::abs(after);
    }
  }
  if (!differs || !(gain > kLeastGainPerCell_mm * nx * R)) return false;  // below lies rounding
  for (int x = 0; x < nx; ++x)
    for (int b = 0; b < K; ++b) problem.set_drop(x, first + b, std::uint8_t(pattern(x) >> b & 1));
  return true;
}

template <int K>
StripResult sweep(LayerProblem& problem, const StripOptions& options, const ParallelFor& parallel) {
  const int strips = problem.ny() - K + 1, classes = K + 2;
  StripResult result;
  std::vector<std::uint8_t> stale(std::size_t(strips), 1), improved(std::size_t(strips), 0);
  std::vector<int> due;
  for (; result.sweeps < options.max_sweeps; ++result.sweeps) {
    bool any = false;
    for (int k = 0; k < classes; ++k) {
      due.clear();
      for (int first = k; first < strips; first += classes)
        if (stale[std::size_t(first)]) due.push_back(first);
      if (due.empty()) continue;
      any = true;
      constexpr int kBatch = 8;
      parallel((int(due.size()) + kBatch - 1) / kBatch, [&](int batch) {
        Strip<K> strip(problem.nx());
        for (int n = batch * kBatch; n < std::min(int(due.size()), (batch + 1) * kBatch); ++n)
          improved[std::size_t(due[std::size_t(n)])] = strip.improve(problem, due[std::size_t(n)]);
      });
      for (const int first : due) {
        ++result.strips;
        stale[std::size_t(first)] = 0;
        if (!improved[std::size_t(first)]) continue;
        ++result.improved;
        // Strips that see an error or a droplet of these rows: those up to K + 1 rows away.
        for (int other = std::max(0, first - K - 1); other <= std::min(strips - 1, first + K + 1); ++other)
          if (other != first) stale[std::size_t(other)] = 1;
      }
    }
    if (!any) {
      result.settled = true;
      break;
    }
  }
  return result;
}

}  // namespace

void serially(int n, const std::function<void(int)>& body) {
  for (int i = 0; i < n; ++i) body(i);
}

StripResult sweep_strips(LayerProblem& problem, const StripOptions& o, const ParallelFor& parallel) {
  if (o.rows < 1 || o.rows > 6) throw std::invalid_argument("strip rows = " + std::to_string(o.rows) + " is outside 1..6");
  const StripOptions fitted{std::min(o.rows, problem.ny()), o.max_sweeps};
  switch (fitted.rows) {
    case 1: return sweep<1>(problem, fitted, parallel);
    case 2: return sweep<2>(problem, fitted, parallel);
    case 3: return sweep<3>(problem, fitted, parallel);
    case 4: return sweep<4>(problem, fitted, parallel);
    case 5: return sweep<5>(problem, fitted, parallel);
    default: return sweep<6>(problem, fitted, parallel);
  }
}

}  // namespace firn::control::mpc
