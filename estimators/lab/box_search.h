// minimise_in_box computes the smallest value that a search finds of a function over the unit box: globally
// by DIRECT-L, then locally by Nelder-Mead from the best point (NLopt). It ends on its count of evaluations.
#pragma once

#include <functional>
#include <span>
#include <vector>

namespace firn::lab {

struct BoxPoint {
  std::vector<double> u;  ///< each in [0, 1]
  double value = 0.0;
};

/// @param start evaluated first, its coordinates in [0, 1]; an empty one is a box without dimensions, whose
/// only point is evaluated once
/// @param evaluations of the function at most; two thirds of them global
/// @returns every evaluated point in order. The best one is that of the smallest value, the first of equals.
/// @throws exceptions of the function
std::vector<BoxPoint> minimise_in_box(const std::function<double(std::span<const double>)>& function,
                                      std::span<const double> start, int evaluations);

}  // namespace firn::lab
