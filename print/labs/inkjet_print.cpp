#include "print/labs/inkjet_print.h"

#include "print/inputs/targets.h"

namespace firn {
namespace {

constexpr double kUm = 1e3;  // per mm

double tolerance_um(const Experiment& e) {
  const std::string& scheme = e.control.scheme;
  if (scheme == "pattern" || scheme == "registration" ||
      (scheme == "open_loop" && e.control.open_loop.layers > 0))
    return 0.0;
  return (e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm) * kUm;
}

Experiment fullest() {
  Experiment e;
  e.estimator.droplets = "on";
  e.control.adapt_model = "on";
  e.control.height_estimate = "kalman";
  e.camera.use = OnOff::kOn;
  return e;
}

Blobs example_inputs(const Experiment& e) { return make_target_inputs(e, "", nullptr); }

}  // namespace

const PrintLab kInkjetPrint{
    "inkjet",        &make_target_inputs,    nullptr, &check_target_inputs, &tolerance_um, &fullest,
    &example_inputs, &report::kDropletReport};

}  // namespace firn
