#include "core/motion/thesis/savitzky_golay.h"

#include <cstddef>

namespace firn::motion::thesis {
namespace {

/// Weights of the cubic fit over positions -h..h, evaluated at position `at`: from the orthogonal (Gram)
/// polynomials 1, u, u^2 - m2 / m0, u^3 - (m4 / m2) u.
std::vector<double> weights(int half, int at) {
  double m0 = 0, m2 = 0, m4 = 0;
  for (int u = -half; u <= half; ++u) {
    m0 += 1;
    m2 += double(u) * u;
    m4 += double(u) * u * u * u;
  }
  const auto p2 = [&](double u) { return u * u - m2 / m0; };
  const auto p3 = [&](double u) { return u * u * u - m4 / m2 * u; };
  double n2 = 0, n3 = 0;
  for (int u = -half; u <= half; ++u) {
    n2 += p2(u) * p2(u);
    n3 += p3(u) * p3(u);
  }
  std::vector<double> w;
  for (int u = -half; u <= half; ++u)
    w.push_back(1 / m0 + double(u) * at / m2 + p2(u) * p2(at) / n2 + p3(u) * p3(at) / n3);
  return w;
}

}  // namespace

std::vector<double> local_cubic(std::span<const double> x, int window) {
  std::vector<double> out(x.begin(), x.end());
  const std::size_t n = x.size(), width = std::size_t(window), half = width / 2;
  if (n < width) return out;
  std::vector<std::vector<double>> table;
  for (int at = -int(half); at <= int(half); ++at) table.push_back(weights(int(half), at));
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t first = i < half ? 0 : i + half >= n ? n - width : i - half;
    const std::vector<double>& w = table[i - first];
    double sum = 0.0;
    for (std::size_t k = 0; k < width; ++k)
      sum += w[k] * (x[first + k] - x[first]);  // differences: no lost digits
    out[i] = x[first] + sum;
  }
  return out;
}

std::vector<double> savitzky_golay_7(std::span<const double> samples) { return local_cubic(samples, 7); }

}  // namespace firn::motion::thesis
