#include "procs/controller/python_surface.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "core/control/python_scheme.h"
#include "core/control/surface/surface_controller_base.h"
#include "python/host/load.h"
#include "python/host/recorded_files.h"

namespace firn {
namespace {

constexpr double kLongestAction_s = 50.0;  // as of a decision of droplets (python_controller.cpp)

/// The wish of a class in place of an action.
struct Wish {
  control::SurfaceDecision::Kind kind;
  std::string reason;
};

class PythonLaw final : public control::SurfaceControllerBase {
 public:
  PythonLaw(const control::SurfaceOptions& options, std::uint64_t seed, const Blobs& inputs)
      : SurfaceControllerBase(options) {
    const control::PythonScheme scheme = control::parse_python_scheme(options.scheme);
    const control::ActionBounds bounds = action_bounds(options);
    python::Parcel setup;
    setup.set("interval_mm", options.interval_mm);
    setup.set("low", bounds.low);
    setup.set("high", bounds.high);
    setup.set("last_layer", options.last_layer);
    setup.set_seed(seed);
    object_ = python::host().make_object(
        python::Kind::kSurface, python::recorded_files(inputs, python::kControllerRole, scheme.file_name()),
        {scheme.class_name, scheme.arguments}, setup, kLongestAction_s);
  }

  /// Of the last call; empty: an action.
  std::optional<Wish> wish;
  std::string reason;

 private:
  HeightMap control_law(const control::SurfaceMeasurement& m, const HeightMap& error, bool) override {
    const GridSpec& g = error.spec;
    python::Parcel given;
    given.text = "layer " + std::to_string(m.layer);
    given.arrays["height_mm"] = {{g.ny, g.nx}, m.height.cells};
    HeightMap answered = error;
    for (double& e : answered.cells) e += target_offset();
    given.arrays["error"] = {{g.ny, g.nx}, std::move(answered.cells)};
    given.arrays["material"] = {{g.ny, g.nx}, {m.material.cells.begin(), m.material.cells.end()}};
    given.set("nominal_mm", m.nominal_mm + options_.target_offset_mm);
    given.set("layer", m.layer);
    given.set("attempt", m.attempt);
    given.set("noise_std_mm", m.noise_std_mm);
    python::Parcel told = object_->call(given);
    using Kind = control::SurfaceDecision::Kind;
    const int kind = int(told.number("kind"));
    wish.reset();
    reason = std::move(told.text);
    if (kind != 0) wish = Wish{kind == 1 ? Kind::kEnd : Kind::kStop, reason};
    HeightMap u(g, 0.0);
    if (kind == 0) u.cells = std::move(told.arrays.at("u").values);
    return control::on_footprint(u, m.material);
  }

  std::unique_ptr<python::Object> object_;
};

class PythonSurface final : public control::SurfaceController {
 public:
  PythonSurface(const control::SurfaceOptions& options, std::uint64_t seed, const Blobs& inputs)
      : law_(options, seed, inputs) {}

  control::SurfaceDecision decide(const control::SurfaceMeasurement& m) override {
    control::SurfaceDecision d = law_.decide(m);
    if (law_.wish) {
      d.kind = law_.wish->kind;
      d.reason = law_.wish->reason;
    } else if (d.kind == control::SurfaceDecision::Kind::kPrint && !law_.reason.empty()) {
      d.reason = law_.reason;
    }
    return d;
  }
  void use_flow(const std::array<double, 2>& factor) override { law_.use_flow(factor); }
  void use_options(const control::SurfaceOptions& options) override { law_.use_options(options); }
  void looked_after() override { law_.looked_after(); }

 private:
  PythonLaw law_;
};

}  // namespace

std::unique_ptr<control::SurfaceController> make_python_surface(const control::SurfaceOptions& options,
                                                                std::uint64_t seed, const Blobs& inputs) {
  return std::make_unique<PythonSurface>(options, seed, inputs);
}

}  // namespace firn
