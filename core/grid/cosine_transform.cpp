#include "core/grid/cosine_transform.h"

#include <cmath>
#include <numbers>

#include "core/exact/exact_math.h"
#include "core/grid/avx2.h"

namespace firn {
namespace {

/// Row k of the orthonormal transform of n cells; transposed it is the inverse.
std::vector<double> matrix_of(int n, bool transposed) {
  std::vector<double> m(std::size_t(n) * std::size_t(n));
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i) {
      const double scale = std::sqrt((k == 0 ? 1.0 : 2.0) / n);
      const double value = scale * exact::cos(std::numbers::pi * k * (2 * i + 1) / (2.0 * n));
      m[std::size_t(transposed ? i * n + k : k * n + i)] = value;
    }
  return m;
}

/// to[r][.] = sum over i of from[r][i] matrix^T[i][.]: `matrix` holds the row of input i.
FIRN_CLONES void multiply(const double* matrix, const double* from, double* to, int count, int n) {
  for (int r = 0; r < count; ++r) {
    double* out = to + std::size_t(r) * std::size_t(n);
    for (int k = 0; k < n; ++k) out[k] = 0.0;
    int i = 0;
    for (; i + 4 <= n; i += 4) {
      const double* in = from + std::size_t(r) * std::size_t(n) + i;
      const double *a = matrix + std::size_t(i) * std::size_t(n), *b = a + n, *c = b + n, *d = c + n;
      for (int k = 0; k < n; ++k) out[k] += (in[0] * a[k] + in[1] * b[k]) + (in[2] * c[k] + in[3] * d[k]);
    }
    for (; i < n; ++i) {
      const double in = from[std::size_t(r) * std::size_t(n) + std::size_t(i)];
      const double* a = matrix + std::size_t(i) * std::size_t(n);
      for (int k = 0; k < n; ++k) out[k] += in * a[k];
    }
  }
}

void turn(const double* from, double* to, int rows, int columns) {
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      to[std::size_t(i) * std::size_t(rows) + std::size_t(j)] =
          from[std::size_t(j) * std::size_t(columns) + std::size_t(i)];
}

}  // namespace

CosineTransform::CosineTransform(int nx, int ny)
    : nx_(nx),
      ny_(ny),
      to_x_(matrix_of(nx, true)),
      from_x_(matrix_of(nx, false)),
      to_y_(matrix_of(ny, true)),
      from_y_(matrix_of(ny, false)),
      turned_(std::size_t(nx) * std::size_t(ny)),
      work_(turned_.size()) {}

void CosineTransform::apply(bool inverse, double* values) {
  multiply((inverse ? from_x_ : to_x_).data(), values, work_.data(), ny_, nx_);
  turn(work_.data(), turned_.data(), ny_, nx_);
  multiply((inverse ? from_y_ : to_y_).data(), turned_.data(), work_.data(), nx_, ny_);
  turn(work_.data(), values, nx_, ny_);
}

void CosineTransform::forward(double* values) { apply(false, values); }
void CosineTransform::inverse(double* values) { apply(true, values); }

std::vector<double> CosineTransform::eigenvalues(int n, double dx) {
  std::vector<double> values(std::size_t(n), 0.0);
  for (int k = 0; k < n; ++k) {
    const double s = 2.0 / dx * exact::sin(std::numbers::pi * k / (2.0 * n));
    values[std::size_t(k)] = s * s;
  }
  return values;
}

}  // namespace firn
