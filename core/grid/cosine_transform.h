// CosineTransform computes the two-dimensional cosine transform of a grid whose walls let nothing through, in
// which the Laplacian is diagonal.
#pragma once

#include <vector>

namespace firn {

/// Orthonormal, type II, and its inverse, by the matrix of each axis: for grids of some 100 cells a side this
/// costs milliseconds, whatever prime factors the length has. All instruction sets give the same bytes.
class CosineTransform {
 public:
  /// @param nx, ny cells, 1 or more
  CosineTransform(int nx, int ny);

  /// In place; nx x ny values, row by row.
  void forward(double* values);
  void inverse(double* values);
  /// Returns (2 / dx sin(pi k / (2 n)))^2, minus the eigenvalue of the second difference of wave k along an
  /// axis of n cells.
  static std::vector<double> eigenvalues(int n, double dx);

 private:
  void apply(bool inverse, double* values);

  int nx_, ny_;
  std::vector<double> to_x_, from_x_, to_y_, from_y_;  ///< n x n matrices
  std::vector<double> turned_, work_;
};

}  // namespace firn
