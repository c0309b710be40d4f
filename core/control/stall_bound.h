// StallBound ends a print whose layers no longer better the part.
#pragma once

#include <memory>
#include <string>

#include "core/control/forwarding_controller.h"
#include "core/control/stall_detector.h"

namespace firn::control {

/// Wraps a scheme that has one target and ends by its own prediction. A prediction can be wrong for ever: a
/// cell whose ink runs off, or a hole that the model fills and the printer does not, gets its droplets layer
/// after layer. The print ends when ControlOptions::stall_layers layers have bettered the part by no more
/// than noise (StallDetector). A second measurement of a layer replaces the first. When the target moves
/// (ControlOptions::target_offset_mm), the comparison begins anew. ReferenceGovernor, which has several
/// targets, asks a detector for each.
class StallBound final : public ForwardingController {
 public:
  StallBound(std::unique_ptr<LayerController> inner, const Setup& setup, const ControlOptions& options);
  Decision decide(const Measurement& measurement) override;
  void use_options(const ControlOptions& options) override;

 private:
  HeightMap target_;
  Mask mask_;
  int layers_;
  double offset_mm_;
  StallDetector detector_;
};

/// Returns the reason of a print that ended so.
std::string stall_reason(int layers);

}  // namespace firn::control
