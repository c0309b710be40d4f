#include "core/control/stall_bound.h"

#include <utility>

#include "core/control/prediction.h"

namespace firn::control {

StallBound::StallBound(std::unique_ptr<LayerController> inner, const Setup& setup,
                       const ControlOptions& options)
    : ForwardingController(std::move(inner)),
      target_(setup.target),
      mask_(setup.mask),
      layers_(options.stall_layers),
      offset_mm_(options.target_offset_mm) {}

void StallBound::use_options(const ControlOptions& options) {
  ForwardingController::use_options(options);
  layers_ = options.stall_layers;
  if (std::exchange(offset_mm_, options.target_offset_mm) != options.target_offset_mm) detector_.clear();
}

Decision StallBound::decide(const Measurement& m) {
  Decision d = inner().decide(m);  // which also checks the measurement
  detector_.rewind(m.layer);
  detector_.add(m, target_, mask_);
  if (d.kind == Decision::Kind::kPrint && detector_.stalled(layers_)) end_print(d, stall_reason(layers_));
  return d;
}

std::string stall_reason(int layers) {
  return "the last " + std::to_string(layers) +
         " layers have bettered the part by no more than the noise of its measurement";
}

}  // namespace firn::control
