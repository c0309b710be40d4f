#include "procs/controller/python_controller.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/control/layer_bound.h"
#include "core/control/prediction.h"
#include "core/control/python_scheme.h"
#include "python/host/load.h"

namespace firn {
namespace {

// Below the longest step of the controller (lcmtypes/channels.table), so that a slow decision is named before
// the node is called dead.
constexpr double kLongestDecision_s = 50.0;

// Without cells where all droplets fall in the centres.
OffsetMap offset_map(const GridSpec& grid, std::span<const std::uint8_t> places) {
  if (places.empty()) return {};
  OffsetMap map(grid);
  std::ranges::copy(places, map.cells.begin());
  return map;
}

class ModelPrediction final : public python::Prediction {
 public:
  explicit ModelPrediction(const control::Setup& setup) : setup_(setup), predict_(setup) {}

  void predict(std::span<const double> height_mm, std::span<const std::uint8_t> drops,
               std::span<const std::uint8_t> places, std::span<double> after_mm) override {
    DropletPattern pattern(setup_.grid);
    std::ranges::copy(drops, pattern.cells.begin());
    const HeightMap before = map_of(height_mm);
    std::ranges::copy(
        predict_.after(before, pattern, materials_at(setup_, before), offset_map(setup_.grid, places)).cells,
        after_mm.begin());
  }

  double objective_mm(std::span<const double> height_mm) override {
    return control::objective_mm(map_of(height_mm), setup_.target, setup_.mask, 1.0);
  }

  void use_model(const deposition::DropletModel& model) {
    setup_.model = model;
    predict_ = control::Predictor(setup_);
  }

 private:
  HeightMap map_of(std::span<const double> height_mm) const {
    HeightMap height(setup_.grid);
    std::ranges::copy(height_mm, height.cells.begin());
    return height;
  }

  control::Setup setup_;
  control::Predictor predict_;
};

class PythonController final : public control::LayerControllerBase {
 public:
  PythonController(const control::Setup& setup, const control::PythonScheme& scheme, const Blobs& inputs)
      : setup_(setup), predict_(setup), prediction_(std::make_shared<ModelPrediction>(setup)) {
    const deposition::DropletModel& m = setup.model;
    python::ControllerSetup s{setup.grid,
                              setup_.target.cells,
                              setup_.mask.cells,
                              m.h1_mm,
                              m.h2_mm,
                              m.h3_mm,
                              m.layer_height_mm(),
                              setup.seed,
                              control::kMaxPythonDrops,
                              kLongestDecision_s,
                              setup.offsets.table};
    controller_ =
        python::host().make_controller(python::recorded_files(inputs, kPythonRole, scheme.file_name()),
                                       {scheme.class_name, scheme.arguments}, s, prediction_);
  }

  control::Decision decide(const control::Measurement& m) override {
    check(m, setup_);
    const HeightMap height = known_heights(m);
    python::Answer answer = controller_->decide(height.cells, m.layer, m.attempt, m.noise_std_mm);
    control::Decision d;
    d.drops = DropletPattern(setup_.grid);
    d.reason = std::move(answer.reason);
    d.materials = materials_at(setup_, height);
    d.kind = answer.kind;
    if (d.kind == PlanDecision::kPrint) {
      d.drops.cells = std::move(answer.drops);
      d.offsets = offset_map(setup_.grid, answer.places);
    }
    predict_.score(d, height, 1.0);
    return d;
  }

  void use_model(const deposition::DropletModel& model) override {
    deposition::check(model);
    setup_.model = model;
    predict_ = control::Predictor(setup_);
    prediction_->use_model(model);
    controller_->use_model(model.h1_mm, model.h2_mm, model.h3_mm);
  }

 private:
  control::Setup setup_;
  control::Predictor predict_;
  std::shared_ptr<ModelPrediction> prediction_;
  std::unique_ptr<python::Controller> controller_;
};

}  // namespace

std::unique_ptr<control::LayerController> make_python_controller(const control::Setup& setup,
                                                                 const control::ControlOptions& options,
                                                                 const Blobs& inputs) {
  check(setup);
  return control::with_layer_bound(
      std::make_unique<PythonController>(setup, control::parse_python_scheme(options.scheme), inputs), setup,
      options);
}

}  // namespace firn
