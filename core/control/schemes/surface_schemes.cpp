// The table of feedback schemes for continuous deposition.
#include <stdexcept>

#include "core/control/surface/adaptive_surface.h"
#include "core/control/surface/disturbance_observer_surface.h"
#include "core/control/surface/smf_surface.h"

namespace firn::control {
namespace {

template <class Controller>
std::unique_ptr<SurfaceController> make(const SurfaceOptions& options) {
  return std::make_unique<Controller>(options);
}

constexpr SurfaceScheme kSurfaceSchemes[] = {
    {"open_loop", "nominal deposition, whatever is measured", &make<OpenLoopSurface>},
    {"smf", "surface-mapping feedback, PID on the error surface [Barnett 2012]", &make<SmfSurface>},
    {"smf_adaptive", "foresees what each place will be short of; its gain adapts from place to place",
     &make<AdaptiveSurface>, kAdaptiveOptions},
    {"smf_foresee",
     "foresees what each material, zone and neighbourhood will be short of, from means over many cells",
     &make<DisturbanceObserverSurface>},
};

}  // namespace

std::span<const SurfaceScheme> surface_schemes() { return kSurfaceSchemes; }

std::unique_ptr<SurfaceController> make_surface_controller(const SurfaceOptions& options) {
  std::string known;
  for (const SurfaceScheme& s : kSurfaceSchemes) {
    if (s.name == options.scheme) return s.make(options);
    known += (known.empty() ? "" : ", ") + std::string(s.name);
  }
  throw std::invalid_argument("control of surfaces: scheme '" + options.scheme + "' is not one of " + known);
}

}  // namespace firn::control
