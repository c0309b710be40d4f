// HeldOut holds the errors of one-step predictions of held-out layers beside those of two predictions that
// know no model: a constant and persistence. A model that predicts no better than these has found nothing.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace firn::statistics {

class HeldOut {
 public:
  int fitted_layers = 0;    ///< the model knows these, the constant is their mean
  int held_out_layers = 0;  ///< predicted, each from those before it

  /// Errors of one cell in one layer: predicted - measured [mm].
  void add(double model_mm, double constant_mm, double persistence_mm) {
    ++cells_;
    model_ += model_mm * model_mm;
    constant_ += constant_mm * constant_mm;
    persistence_ += persistence_mm * persistence_mm;
  }
  std::int64_t cells() const { return cells_; }
  bool known() const { return cells_ > 0; }
  double model_rms_mm() const { return root(model_); }
  double constant_rms_mm() const { return root(constant_); }        ///< mean rise of the fitted layers
  double persistence_rms_mm() const { return root(persistence_); }  ///< rise of the cell in the layer before
  /// Returns true if the model's error is the smallest of the three.
  bool model_is_best() const { return known() && model_ < constant_ && model_ < persistence_; }

 private:
  double root(double sum) const {
    return cells_ > 0 ? std::sqrt(sum / double(cells_)) : std::numeric_limits<double>::quiet_NaN();
  }
  std::int64_t cells_ = 0;
  double model_ = 0.0, constant_ = 0.0, persistence_ = 0.0;  // sums of squares
};

/// Returns the number of layers that a model is fitted to, of all: two thirds, the first ones. 0: too few to
/// hold any out.
inline int fitted_of(int layers) { return layers < 3 ? 0 : (2 * layers + 2) / 3; }

}  // namespace firn::statistics
