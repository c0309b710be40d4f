// StallBound ends a print whose layers no longer better the part.
#pragma once

#include <deque>
#include <memory>

#include "core/control/controller.h"

namespace firn::control {

/// Wraps a scheme that ends by its own prediction. A prediction can be wrong for ever: a cell whose ink runs
/// off, or a hole that the model fills and the printer does not, gets its droplets layer after layer. After
/// layer k the measured mean |error| and the RMS about the target, over the mask, are compared with their
/// least values up to layer k - n, n = ControlOptions::stall_layers. The print ends if neither is less by
/// more than kSigmas standard deviations of the difference of two such means,
///   kSigmas * noise_std * sqrt(2 / cells):
/// what n layers have gained cannot be told from the noise of the measurement. A second measurement of a
/// layer replaces the first. While the part rises by layers the mean |error| falls by a layer each time. When
/// the target moves (ControlOptions::target_offset_mm), the comparison begins anew.
class StallBound final : public LayerController {
 public:
  static constexpr double kSigmas = 3.0;

  StallBound(std::unique_ptr<LayerController> inner, const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override { inner_->use_model(model); }
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override {
    inner_->use_models(inside, rim);
  }
  void use_threads(const ParallelFor& parallel) override { inner_->use_threads(parallel); }
  void use_options(const ControlOptions& options) override;

 private:
  struct Quality {
    int layer = 0;
    double mean_mm = 0.0, rms_mm = 0.0;
  };
  void remember(const Measurement& measurement);
  bool stalled(double noise_std_mm) const;

  std::unique_ptr<LayerController> inner_;
  HeightMap target_;
  Mask mask_;
  double cells_;
  int layers_;
  double offset_mm_;
  std::deque<Quality> quality_;  ///< by layer
};

}  // namespace firn::control
