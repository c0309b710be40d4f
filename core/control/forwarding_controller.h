// ForwardingController is the base of wrappers round a scheme.
#pragma once

#include <memory>
#include <utility>

#include "core/control/controller.h"

namespace firn::control {

/// Forwards everything but decide() to the wrapped scheme. A wrapper that overrides a function calls
/// ForwardingController's too.
class ForwardingController : public LayerController {
 public:
  explicit ForwardingController(std::unique_ptr<LayerController> inner) : inner_(std::move(inner)) {}

  void use_model(const deposition::DropletModel& model) override { inner_->use_model(model); }
  void use_models(const deposition::DropletModel& inside, const deposition::DropletModel& rim) override {
    inner_->use_models(inside, rim);
  }
  void use_threads(const ParallelFor& parallel) override { inner_->use_threads(parallel); }
  void use_options(const ControlOptions& options) override { inner_->use_options(options); }

 protected:
  LayerController& inner() { return *inner_; }

 private:
  std::unique_ptr<LayerController> inner_;
};

}  // namespace firn::control
