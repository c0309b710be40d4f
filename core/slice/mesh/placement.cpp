#include "core/slice/mesh/placement.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "core/exact/exact_math.h"
#include "core/options/range.h"
#include "core/slice/mesh/facet_chunks.h"
#include "core/slice/mesh/snap.h"

namespace firn::slice {
namespace {

using Mode = AxisPlace::Mode;
using Matrix = std::array<double, 9>;
constexpr Matrix kIdentity = {1, 0, 0, 0, 1, 0, 0, 0, 1};

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("placement: " + what); }

Matrix times(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return c;
}

Matrix rotation(int axis, double degrees) {
  double turn = std::fmod(degrees, 360.0);
  if (turn < 0.0) turn += 360.0;
  double c = exact::cos(turn * std::numbers::pi / 180.0), s = exact::sin(turn * std::numbers::pi / 180.0);
  if (std::fmod(turn, 90.0) == 0.0) {  // quarter turns are exact
    const int quarter = int(turn / 90.0) % 4;
    c = quarter == 0 ? 1.0 : quarter == 2 ? -1.0 : 0.0;
    s = quarter == 1 ? 1.0 : quarter == 3 ? -1.0 : 0.0;
  }
  Matrix m = kIdentity;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  m[4 * u] = c;
  m[4 * v] = c;
  m[3 * u + v] = -s;
  m[3 * v + u] = s;
  return m;
}

struct Box {
  std::array<double, 3> low = {kFar, kFar, kFar}, high = {-kFar, -kFar, -kFar};
  std::size_t not_finite = 0;
  static constexpr double kFar = std::numeric_limits<double>::infinity();
  bool empty() const { return !(low[0] <= high[0]); }
  void add(const std::array<double, 3>& p) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  }
  void add(const Box& other) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
    not_finite += other.not_finite;
  }
};

std::array<double, 3> apply(const Matrix& m, const Corner& p) {
  const double x = p[0], y = p[1], z = p[2];
  return {m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z};
}

using Lanes = float __attribute__((vector_size(16)));
#ifdef __SSE2__
Lanes lesser(Lanes a, Lanes b) { return _mm_min_ps(a, b); }
Lanes greater(Lanes a, Lanes b) { return _mm_max_ps(a, b); }
#else
Lanes lesser(Lanes a, Lanes b) { return a < b ? a : b; }
Lanes greater(Lanes a, Lanes b) { return a > b ? a : b; }
#endif

// Most chunks hold only finite numbers: one pass of minima and maxima, four numbers at a time, with a sum
// that is NaN if any number is not finite. The nine numbers of a facet are read as 0..3, 4..7 and 5..8.
bool plain_box(const FacetView& facets, std::size_t first, std::size_t end, Box& box) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  constexpr std::size_t kBegin[3] = {0, 4, 5};
  Lanes low[3], high[3], waste[3] = {};
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = Lanes{kFar, kFar, kFar, kFar};
    high[k] = -low[k];
  }
  const auto add = [&](const std::byte* corners) {
#pragma GCC unroll 3
    for (std::size_t k = 0; k < 3; ++k) {  // so that all nine stay in registers
      Lanes v;
      std::memcpy(&v, corners + sizeof(float) * kBegin[k], sizeof v);
      low[k] = lesser(v, low[k]);
      high[k] = greater(v, high[k]);
      waste[k] += v * 0.0f;
    }
  };
  if (facets.indexed())
    for (std::size_t n = first; n < end; ++n) add(reinterpret_cast<const std::byte*>(facets.facet(n).data()));
  else
    for (std::size_t n = first; n < end; ++n) {
      __builtin_prefetch(facets.soup + n * facets.stride + 2048);
      add(facets.soup + n * facets.stride);
    }
  waste[0] += waste[1] + waste[2];
  if (!(waste[0][0] + waste[0][1] + waste[0][2] + waste[0][3] == 0.0f)) return false;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t axis = (kBegin[k] + i) % 3;
      box.low[axis] = std::min(box.low[axis], double(low[k][i]));
      box.high[axis] = std::max(box.high[axis], double(high[k][i]));
    }
  return true;
}

Box box_of(const FacetView& facets, const Matrix* turned, const ParallelFor& parallel) {
  std::vector<Box> boxes(std::size_t(chunk_count(facets)));
  for_chunks(facets, Pass::kFirst, parallel, [&](int chunk, std::size_t first, std::size_t end) {
    Box box;
    if (turned || !plain_box(facets, first, end, box))
      for (std::size_t n = first; n < end; ++n) {
        const std::array<Corner, 3> f = facets.facet(n);
        if (!finite(f))
          ++box.not_finite;
        else
          for (const Corner& c : f) box.add(apply(turned ? *turned : kIdentity, c));
      }
    boxes[std::size_t(chunk)] = box;
  });
  Box all;
  for (const Box& b : boxes) all.add(b);
  return all;
}

double float_step(const Box& raw) {
  float largest = 0.0f;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, float(std::abs(raw.low[axis])), float(std::abs(raw.high[axis]))});
  return double(std::nextafter(largest, std::numeric_limits<float>::infinity())) - double(largest);
}

Box scaled(const Box& raw, const Matrix& m) {
  Box box;
  box.not_finite = raw.not_finite;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = m[4 * axis] * raw.low[axis], b = m[4 * axis] * raw.high[axis];
    box.low[axis] = std::min(a, b);
    box.high[axis] = std::max(a, b);
  }
  return box;
}

bool diagonal(const Matrix& m) {
  return m[1] == 0.0 && m[2] == 0.0 && m[3] == 0.0 && m[5] == 0.0 && m[6] == 0.0 && m[7] == 0.0;
}

Matrix linear(const Placement& p) {
  if (!(std::isfinite(p.unit_mm) && p.unit_mm > 0.0))
    refuse("unit of " + shortest_text(p.unit_mm) + " mm must be above 0");
  Matrix m = kIdentity;
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(p.scale[axis]) || p.scale[axis] == 0.0)
      refuse("scale[" + std::to_string(axis) + "] = " + std::to_string(p.scale[axis]) +
             " must be a number other than 0");
    if (!std::isfinite(p.rotation_deg[axis]))
      refuse("rotation_deg[" + std::to_string(axis) + "] is no number");
    m[4 * axis] = p.scale[axis] * (p.unit_mm * geometry::kUnitsPerMm);
  }
  std::array<int, 3> sorted = p.order;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != std::array<int, 3>{0, 1, 2}) refuse("order must name each axis once");
  for (const int axis : p.order) m = times(rotation(axis, p.rotation_deg[axis]), m);
  return m;
}

// All boxes are about `origin`.
std::array<double, 3> translation(const Placement& p, const Matrix& m, const Box& raw, const Box& box,
                                  const std::array<double, 3>& origin) {
  const bool as_in_file =
      p.scale == std::array<double, 3>{1, 1, 1} && p.rotation_deg == std::array<double, 3>{0, 0, 0};
  std::array<double, 3> shift{};
  for (int axis = 0; axis < 3; ++axis) {
    const AxisPlace& place = p.translation[axis];
    const double middle = 0.5 * (box.low[axis] + box.high[axis]);
    if (place.mode == Mode::kNumber) {
      if (!std::isfinite(place.value_mm)) refuse("translation[" + std::to_string(axis) + "] is no number");
      shift[axis] = place.value_mm * geometry::kUnitsPerMm - box.low[axis];
    } else if (place.mode == Mode::kCentre) {
      shift[axis] = -middle;
    } else if (place.mode == Mode::kOriginal) {
      shift[axis] =
          (0.5 * (raw.low[axis] + raw.high[axis]) + origin[axis]) * (p.unit_mm * geometry::kUnitsPerMm) -
          middle;
    } else if (!as_in_file) {  // [3.1.2]: minimum at 0 before scaling and rotation
      shift[axis] = -(m[3 * axis] * raw.low[0] + m[3 * axis + 1] * raw.low[1] + m[3 * axis + 2] * raw.low[2]);
    } else {
      shift[axis] = origin[axis] * m[4 * axis];
    }
  }
  return shift;
}

}  // namespace

Affine place(const FacetView& facets, const Placement& placement, const ParallelFor& parallel) {
  Affine a;
  a.matrix = linear(placement);
  a.mirrors = placement.scale[0] * placement.scale[1] * placement.scale[2] < 0.0;
  const Box raw = box_of(facets, nullptr, parallel);
  a.not_finite = raw.not_finite;
  if (raw.empty()) {
    a.low = {1, 1, 1};
    a.high = {0, 0, 0};
    return a;
  }
  const Box box = diagonal(a.matrix) ? scaled(raw, a.matrix) : box_of(facets, &a.matrix, parallel);
  a.shift = translation(placement, a.matrix, raw, box, facets.origin);
  a.coarse_mm = float_step(raw) * placement.unit_mm;
  std::array<std::int32_t, 3> low{}, high{};
  for (int axis = 0; axis < 3; ++axis) {
    const double l = box.low[axis] + a.shift[axis], h = box.high[axis] + a.shift[axis];
    if (!(l >= -double(kMaxUnits) && h <= double(kMaxUnits)))
      refuse("the part reaches from " + std::to_string(l / geometry::kUnitsPerMm) + " to " +
             std::to_string(h / geometry::kUnitsPerMm) + " mm on axis " + std::string(1, "xyz"[axis]) +
             ", beyond the limit of " + std::to_string(kMaxUnits / geometry::kUnitsPerMm) +
             " mm (is the unit right?)");
    low[axis] = to_grid(l);
    high[axis] = to_grid(h);
  }
  a.low = {low[0], low[1], low[2]};
  a.high = {high[0], high[1], high[2]};
  return a;
}

}  // namespace firn::slice
