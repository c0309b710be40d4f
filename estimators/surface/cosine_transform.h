// CosineTransform computes the orthonormal two-dimensional DCT-II and its inverse for any size.
#pragma once

#include <span>
#include <vector>

namespace firn::surface {

/// cos(pi k / n) by reduction to an eighth turn and a power series: only + - * /, so that every machine has
/// the same table. @pre n > 0
double cos_pi(long k, long n);

/// Transforms of ny x nx row-major values. Even x even sizes go through OpenCV's dct (which takes no others),
/// the rest through cosine matrices, at nx ny (nx + ny) multiplications. Not for use by two threads at a
/// time.
class CosineTransform {
 public:
  CosineTransform(int nx, int ny);  ///< @pre both above 0
  void forward(std::span<const double> in, std::span<double> out) { run(in, out, false); }
  void inverse(std::span<const double> in, std::span<double> out) { run(in, out, true); }

 private:
  void run(std::span<const double> in, std::span<double> out, bool inverse);

  int nx_, ny_;
  bool opencv_;
  std::vector<double> along_x_, along_y_;  // matrices, row = frequency; empty when OpenCV serves
  std::vector<double> scratch_;
};

}  // namespace firn::surface
