#include "estimators/surface/cosine_transform.h"

#include <cmath>
#include <opencv2/core.hpp>

namespace firn::surface {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Power series about 0 for |x| <= pi / 4: 12 terms leave less than 1e-20.
double cos_small(double x) {
  double term = 1.0, sum = 1.0;
  for (int n = 1; n <= 12; ++n) sum += term *= -x * x / double((2 * n - 1) * (2 * n));
  return sum;
}
double sin_small(double x) {
  double term = x, sum = x;
  for (int n = 1; n <= 12; ++n) sum += term *= -x * x / double(2 * n * (2 * n + 1));
  return sum;
}

// Row f holds the values of frequency f: sqrt((f ? 2 : 1) / n) cos(pi f (2 i + 1) / (2 n)).
std::vector<double> cosine_matrix(int n) {
  std::vector<double> m;
  for (int f = 0; f < n; ++f)
    for (int i = 0; i < n; ++i)
      m.push_back(std::sqrt((f ? 2.0 : 1.0) / n) * cos_pi(long(f) * (2 * i + 1), 2L * n));
  return m;
}

// out (rows x n) = in (rows x n) times m transposed (inverse: times m), each row a transform.
void transform_rows(const double* in, double* out, int rows, int n, const std::vector<double>& m,
                    bool inverse) {
  for (int r = 0; r < rows; ++r) {
    const double* x = in + std::ptrdiff_t(r) * n;
    double* y = out + std::ptrdiff_t(r) * n;
    for (int k = 0; k < n; ++k) y[k] = 0.0;
    for (int f = 0; f < n; ++f) {
      const double* row = m.data() + std::ptrdiff_t(f) * n;
      if (inverse) {
        for (int i = 0; i < n; ++i) y[i] += x[f] * row[i];
      } else {
        double sum = 0.0;
        for (int i = 0; i < n; ++i) sum += x[i] * row[i];
        y[f] = sum;
      }
    }
  }
}

void transpose(const double* in, double* out, int rows, int columns) {
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) out[std::ptrdiff_t(c) * rows + r] = in[std::ptrdiff_t(r) * columns + c];
}

}  // namespace

double cos_pi(long k, long n) {
  k %= 2 * n;
  if (k < 0) k = -k;
  if (k > n) k = 2 * n - k;                    // cos is even about pi
  const double sign = 2 * k > n ? -1.0 : 1.0;  // and odd about pi / 2
  if (2 * k > n) k = n - k;
  if (2 * k == n) return 0.0;
  if (4 * k <= n) return sign * cos_small(kPi * double(k) / double(n));
  return sign * sin_small(kPi * double(n - 2 * k) / double(2 * n));
}

CosineTransform::CosineTransform(int nx, int ny) : nx_(nx), ny_(ny), opencv_(nx % 2 == 0 && ny % 2 == 0) {
  if (opencv_) return;
  along_x_ = cosine_matrix(nx);
  along_y_ = cosine_matrix(ny);
  scratch_.resize(2 * std::size_t(nx) * std::size_t(ny));
}

void CosineTransform::run(std::span<const double> in, std::span<double> out, bool inverse) {
  if (opencv_) {
    const cv::Mat from(ny_, nx_, CV_64F, const_cast<double*>(in.data()));
    cv::Mat to(ny_, nx_, CV_64F, out.data());
    cv::dct(from, to, inverse ? cv::DCT_INVERSE : 0);
    return;
  }
  double* a = scratch_.data();
  double* b = a + std::size_t(nx_) * std::size_t(ny_);
  transform_rows(in.data(), a, ny_, nx_, along_x_, inverse);
  transpose(a, b, ny_, nx_);
  transform_rows(b, a, nx_, ny_, along_y_, inverse);
  transpose(a, out.data(), nx_, ny_);
}

}  // namespace firn::surface
