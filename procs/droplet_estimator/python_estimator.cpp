#include "procs/droplet_estimator/python_estimator.h"

#include <algorithm>
#include <utility>

#include "core/control/python_scheme.h"
#include "python/host/load.h"
#include "python/host/recorded_files.h"

namespace firn {
namespace {

// Below the longest step of the node (lcmtypes/channels.table).
constexpr double kLongestLesson_s = 50.0;

python::Array map_array(const GridSpec& g, std::vector<double> values) {
  return {{g.ny, g.nx}, std::move(values)};
}

python::Array drops_array(const GridSpec& g, const std::vector<droplet::Pass>& passes) {
  python::Array drops{{int(passes.size()), g.ny, g.nx}, std::vector<double>(passes.size() * g.size())};
  for (std::size_t n = 0; n < passes.size(); ++n)
    for (const std::uint32_t cell : passes[n].cells) drops.values[n * g.size() + cell] += passes[n].share;
  return drops;
}

}  // namespace

PythonEstimator::PythonEstimator(const Experiment& e, const Mask& mask, const Blobs& inputs) : grid_(e.grid) {
  const control::PythonScheme scheme = control::parse_python_scheme(e.estimator.droplets);
  python::Parcel setup;
  setup.set_grid(e.grid);
  setup.set("h1_mm", e.model.h1_mm);
  setup.set("h2_mm", e.model.h2_mm);
  setup.set("h3_mm", e.model.h3_mm);
  setup.set_seed(e.control.seed);
  setup.arrays["mask"] = map_array(grid_, {mask.cells.begin(), mask.cells.end()});
  object_ = python::host().make_object(
      python::Kind::kEstimator, python::recorded_files(inputs, python::kEstimatorRole, scheme.file_name()),
      {scheme.class_name, scheme.arguments}, setup, kLongestLesson_s);
  estimate_.model = {e.model.h1_mm, e.model.h2_mm, e.model.h3_mm};
}

const droplet::Estimate& PythonEstimator::learn(const PrintedLayer& m) {
  python::Parcel given;
  given.text = "layer " + std::to_string(m.layer);
  given.arrays["height_mm"] = map_array(grid_, m.height.cells);
  python::Array learn = map_array(grid_, {});
  for (const droplet::Use use : m.use) learn.values.push_back(use == droplet::Use::kLearn ? 1.0 : 0.0);
  given.arrays["learn"] = std::move(learn);
  given.arrays["drops"] = drops_array(grid_, m.passes);
  given.set("layer", m.layer);
  given.set("attempt", m.attempt);
  given.set("noise_std_mm", m.noise_std_mm);
  const python::Parcel told = object_->call(given);
  if (told.arrays.empty()) return estimate_;  // it has nothing to say yet
  estimate_.model = {told.number("h1_mm"), told.number("h2_mm"), told.number("h3_mm")};
  std::ranges::copy(told.arrays.at("covariance_mm2").values, estimate_.covariance_mm2.m.begin());
  estimate_.droplet_scatter = told.number("droplet_scatter");
  if (m.layer > learned_) {
    learned_ = m.layer;
    ++estimate_.layers;
    for (const droplet::Pass& p : m.passes) estimate_.droplets += std::int64_t(p.cells.size());
  }
  return estimate_;
}

}  // namespace firn
