// Computes Holm's adjusted p-values of a family of tests.
#pragma once

#include <span>
#include <vector>

namespace firn::statistics {

/// Holm's step-down adjustment [Holm 1979, Scand. J. Statistics 6]: reject where the adjusted value is at
/// most alpha, and the chance of any false rejection in the family is at most alpha, however the tests depend
/// on each other. The i-th smallest of m p-values becomes max over j <= i of min(1, (m - j + 1) p_(j)). Order
/// as given.
std::vector<double> holm(std::span<const double> p_values);

}  // namespace firn::statistics
