// The table of feedback schemes.
#include <stdexcept>
#include <utility>

#include "core/control/auto/auto_scheme.h"
#include "core/control/controller.h"
#include "core/control/forwarding_controller.h"
#include "core/control/graph/graph_mpc.h"
#include "core/control/layer_bound.h"
#include "core/control/mpc/reference_governor.h"
#include "core/control/open_loop.h"
#include "core/control/pattern.h"
#include "core/control/registration.h"
#include "core/control/smf.h"
#include "core/control/spatial_ilc.h"
#include "core/control/stall_bound.h"
#include "core/control/target_offset.h"
#include "core/control/threshold.h"

namespace firn::control {
namespace {

template <class Controller>
std::unique_ptr<LayerController> make(const Setup& setup, const ControlOptions& options) {
  return std::make_unique<Controller>(setup, options);
}

std::unique_ptr<LayerController> make_mpc(const Setup& setup, const ControlOptions& options) {
  if (options.mpc.finish_layers > 0.0 || options.mpc.rim_lead_layers > 0.0 || options.mpc.rise_layers > 0.0)
    return std::make_unique<ReferenceGovernor>(setup, options);
  return std::make_unique<StallBound>(std::make_unique<Mpc>(setup, options), setup, options);
}

std::unique_ptr<LayerController> make_spatial_ilc(const Setup& setup, const ControlOptions& options) {
  return std::make_unique<StallBound>(std::make_unique<SpatialIlc>(setup, options), setup, options);
}

std::unique_ptr<LayerController> make_graph_mpc(const Setup& setup, const ControlOptions& options) {
  return std::make_unique<StallBound>(std::make_unique<GraphMpc>(setup, options), setup, options);
}

constexpr Scheme kSchemes[] = {
    {"open_loop", "every layer as sliced, whatever is measured", &make<OpenLoop>},
    {"smf", "surface-mapping feedback, PID per cell, drop on demand [Barnett 2012]", &make<Smf>},
    {"threshold", "one droplet where the layer is short by more than a threshold [Cohen and Lipson 2010]",
     &make<Threshold>},
    {"mpc", "model predictive control with stochastic greedy search [Lu 2015]", &make_mpc},
    {"spatial_ilc", "norm-optimal spatial iterative learning control, after Hoelzle and Barton 2016",
     &make_spatial_ilc, kSpatialIlcOptions},
    {"graph_mpc", "predictive control of volumes with flow along a graph, after Guo et al. 2018",
     &make_graph_mpc, kGraphMpcOptions},
    {"auto", "chooses among these by what the first layers tell of the lab, and says why", &make<AutoScheme>},
    {"pattern", "patterns to learn from: random, identification prints, squares [Lu 2015, III-A, V-C]",
     &make<PatternPrint>},
    {"registration", "marks of both nozzles, to measure the offset of the second (firn calibrate)",
     &make<RegistrationPrint>},
};

// Stops for the operator at ControlOptions::max_layers.
class LayerBound final : public ForwardingController {
 public:
  LayerBound(std::unique_ptr<LayerController> inner, GridSpec grid, int max_layers)
      : ForwardingController(std::move(inner)), grid_(grid), max_layers_(max_layers) {}
  Decision decide(const Measurement& m) override {
    Decision d = inner().decide(m);
    if (d.kind != Decision::Kind::kPrint || m.layer < max_layers_) return d;
    d.kind = Decision::Kind::kStop;
    d.drops = DropletPattern(grid_);
    d.objective_mm = d.objective_none_mm;
    d.reason = "the scheme wants a layer beyond max_layers = " + std::to_string(max_layers_);
    return d;
  }
  void use_options(const ControlOptions& options) override {
    check_options("control", kControlOptions, options);
    ForwardingController::use_options(options);
    max_layers_ = options.max_layers;
  }

 private:
  GridSpec grid_;
  int max_layers_;
};

}  // namespace

std::span<const Scheme> schemes() { return kSchemes; }

std::unique_ptr<LayerController> with_layer_bound(std::unique_ptr<LayerController> scheme, const Setup& setup,
                                                  const ControlOptions& options) {
  check_options("control", kControlOptions, options);
  return std::make_unique<LayerBound>(std::make_unique<TargetOffset>(std::move(scheme), options), setup.grid,
                                      options.max_layers);
}

std::unique_ptr<LayerController> make_controller(const Setup& setup, const ControlOptions& options) {
  check_options("control", kControlOptions, options);
  std::string known;
  for (const Scheme& s : kSchemes) {
    if (s.name == options.scheme) {
      check(setup);
      return with_layer_bound(s.make(setup, options), setup, options);
    }
    known += (known.empty() ? "" : ", ") + std::string(s.name);
  }
  throw std::invalid_argument("control: scheme '" + options.scheme + "' is not one of " + known);
}

}  // namespace firn::control
