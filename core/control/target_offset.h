// TargetOffset moves the target of a scheme up or down while it prints.
#pragma once

#include <memory>
#include <utility>

#include "core/control/forwarding_controller.h"

namespace firn::control {

/// Wraps a scheme that aims at h_d: with ControlOptions::target_offset_mm = o it aims at h_d + o. The scheme
/// is given h - o in place of the measured height h, so that every error h_d - h is the one about h_d + o.
/// With two inks M [Lu 2015, IV-B] moves along. A scheme without feedback prints as before.
class TargetOffset final : public ForwardingController {
 public:
  TargetOffset(std::unique_ptr<LayerController> inner, const ControlOptions& options)
      : ForwardingController(std::move(inner)), offset_mm_(options.target_offset_mm) {}
  Decision decide(const Measurement& measurement) override;
  void use_options(const ControlOptions& options) override {
    ForwardingController::use_options(options);
    offset_mm_ = options.target_offset_mm;
  }

 private:
  double offset_mm_;
};

}  // namespace firn::control
