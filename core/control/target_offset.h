// TargetOffset moves the target of a scheme up or down while it prints.
#pragma once

#include <memory>

#include "core/control/controller.h"

namespace firn::control {

/// Wraps a scheme that aims at h_d: with ControlOptions::target_offset_mm = o it aims at h_d + o. The scheme
/// is given h - o in place of the measured height h, so that every error h_d - h is the one about h_d + o.
/// With two inks M [Lu 2015, IV-B] moves along. A scheme without feedback prints as before.
class TargetOffset final : public LayerController {
 public:
  TargetOffset(std::unique_ptr<LayerController> inner, const ControlOptions& options)
      : inner_(std::move(inner)), offset_mm_(options.target_offset_mm) {}
  Decision decide(const Measurement& measurement) override;
  void use_model(const deposition::DropletModel& model) override { inner_->use_model(model); }
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override {
    inner_->use_models(inside, rim);
  }
  void use_threads(const ParallelFor& parallel) override { inner_->use_threads(parallel); }
  void use_options(const ControlOptions& options) override {
    inner_->use_options(options);
    offset_mm_ = options.target_offset_mm;
  }

 private:
  std::unique_ptr<LayerController> inner_;
  double offset_mm_;
};

}  // namespace firn::control
