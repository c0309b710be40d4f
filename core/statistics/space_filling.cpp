#include "core/statistics/space_filling.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>
#include <string>

#include "core/grid/random.h"

namespace firn::statistics {
namespace {

constexpr int kBits = 32;
constexpr double kOne = 4294967296.0;  // 2^kBits

// Primitive polynomial of degree s with the inner coefficients a, and the first s direction numbers.
struct Direction {
  int degree;
  std::uint32_t inner;
  std::array<std::uint32_t, 4> first;
};
constexpr std::array<Direction, kMaxDesignAxes - 1> kJoeKuo{
    {{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}, {3, 2, {1, 1, 1}}, {4, 1, {1, 1, 3, 3}}}};

using Directions = std::array<std::uint32_t, kBits>;

Directions directions_of(int axis) {
  Directions v{};
  if (axis == 0) {
    for (int k = 0; k < kBits; ++k) v[std::size_t(k)] = 1u << (kBits - 1 - k);
    return v;
  }
  const Direction& d = kJoeKuo[std::size_t(axis - 1)];
  for (int k = 0; k < kBits; ++k) {
    std::uint32_t& next = v[std::size_t(k)];
    if (k < d.degree) {
      next = d.first[std::size_t(k)] << (kBits - 1 - k);
      continue;
    }
    const std::uint32_t oldest = v[std::size_t(k - d.degree)];
    next = oldest ^ (oldest >> d.degree);
    for (int i = 1; i < d.degree; ++i)
      if ((d.inner >> (d.degree - 1 - i)) & 1u) next ^= v[std::size_t(k - i)];
  }
  return v;
}

void check(int points, int axes) {
  if (points < 1)
    throw std::invalid_argument("a design has " + std::to_string(points) + " points; 1 is the least");
  if (axes < 1 || axes > kMaxDesignAxes)
    throw std::invalid_argument("a design has " + std::to_string(axes) + " axes, not 1 to " +
                                std::to_string(kMaxDesignAxes));
}

}  // namespace

Design latin_hypercube(int points, int axes, std::uint64_t seed) {
  check(points, axes);
  Design design{axes, std::vector<double>(std::size_t(points) * std::size_t(axes))};
  std::vector<int> interval(static_cast<std::size_t>(points));
  for (int axis = 0; axis < axes; ++axis) {
    RandomStream random(seed, Purpose::kInstance, std::uint32_t(axis));
    std::iota(interval.begin(), interval.end(), 0);
    for (std::uint32_t n = std::uint32_t(points); n > 1; --n)
      std::swap(interval[n - 1], interval[random.below(n)]);
    for (std::size_t n = 0; n < interval.size(); ++n)
      design.values[n * std::size_t(axes) + std::size_t(axis)] = (interval[n] + random.uniform()) / points;
  }
  return design;
}

Design sobol(int points, int axes, std::uint64_t seed) {
  check(points, axes);
  Design design{axes, std::vector<double>(std::size_t(points) * std::size_t(axes))};
  for (int axis = 0; axis < axes; ++axis) {
    const Directions v = directions_of(axis);
    std::uint32_t x = std::uint32_t(random_bits({seed, Purpose::kInstance, std::uint32_t(axis), 1, 0}));
    for (std::size_t n = 0; n < std::size_t(points); ++n) {
      design.values[n * std::size_t(axes) + std::size_t(axis)] = x / kOne;
      std::size_t zero = 0;  // the lowest bit of n that is 0: Gray code
      while ((n >> zero) & 1u) ++zero;
      x ^= v[zero];
    }
  }
  return design;
}

}  // namespace firn::statistics
