// Space-filling designs: points of the unit cube that cover each axis evenly. The same seed gives the same
// points on every machine.
#pragma once

#include <cstdint>
#include <vector>

namespace firn::statistics {

inline constexpr int kMaxDesignAxes = 6;

/// Points of a design, one after the other.
struct Design {
  int axes = 0;
  std::vector<double> values;  ///< in [0, 1): points x axes
  double at(int point, int axis) const {
    return values[std::size_t(point) * std::size_t(axes) + std::size_t(axis)];
  }
};

/// Latin hypercube [McKay, Beckman and Conover, "A comparison of three methods for selecting values of input
/// variables", Technometrics 21, 1979]: each of `points` equal intervals of each axis holds one point, at a
/// random place in it.
/// @throws std::invalid_argument: points < 1, axes outside [1, kMaxDesignAxes]
Design latin_hypercube(int points, int axes, std::uint64_t seed);

/// The first points of Sobol's sequence with the direction numbers of Joe and Kuo ("Constructing Sobol
/// sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30, 2008), shifted digitally by
/// the seed: of 2^k points each axis has one in each of 2^k equal intervals, and the first n are a design for
/// every n.
/// @throws std::invalid_argument as above
Design sobol(int points, int axes, std::uint64_t seed);

}  // namespace firn::statistics
