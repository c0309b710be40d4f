#include "core/motion/certified/segment_curve.h"

#include <algorithm>
#include <cmath>

#include "core/motion/curve/frechet.h"

namespace firn::motion {
namespace {

/// Radius of the tube about the points for a fit with these curve options.
double tube_radius_mm(const CurveOptions& spec, const PlanOptions& options) {
  if (spec.tolerance_mm > 0.0) return spec.tolerance_mm;
  return spec.hold_mm > 0.0 ? kHeldRadiusShare * spec.hold_mm : fit_radius_mm(options);
}

/// Maximum deviation at which a shape needs no further try.
double allowed_mm(Shape shape, const PlanOptions& options) {
  const bool any = options.tolerance_mm > 0.0 ? shape == Shape::kPlain : shape == Shape::kFitted;
  return any ? kUnlimited : allowed_deviation_mm(options);
}

/// Reduces the quantities by which a recognised curve leaves its tolerance, one after another: the tolerance
/// that its ramps use, the sagitta below which chords are arcs, at last the ramp itself.
class Reductions {
 public:
  explicit Reductions(double allowed_mm) : allowed_mm_(allowed_mm) {}

  /// @param share of the present deviation that the next curve aims at @param first nothing was reduced yet
  void apply(double share, bool first, CurveOptions& spec) {
    if (first && share > kSlightReduction && spec.tolerance_mm > 0.0) {
      spec.tolerance_mm *= share;
    } else if (spec.held_sagitta_mm == 0.0) {
      spec.tolerance_mm = allowed_mm_;
      spec.held_sagitta_mm = std::min(kSagittaMm, spec.tolerance_mm);
    } else {
      if (count_ == 0)
        spec.held_sagitta_mm *= kSagittaReduction;
      else
        spec.tolerance_mm *= share;
      ++count_;
      if (count_ > kReductionsOfFullRamp) spec.ramp_mm = std::max(kRampReduction * spec.ramp_mm, kMinRamp_mm);
    }
  }

 private:
  double allowed_mm_;
  int count_ = 0;  ///< since chords are held to their sagitta
};

}  // namespace

void SegmentCurve::follow(const PathPart& part) {
  followed_ = sample_given(part.points, part.given, samples_);
}

void SegmentCurve::measure(std::span<const Point2> points, const PlanOptions& options,
                           StopSegment& out) const {
  const double hold = hold_mm(options);
  out.deviation_mm = frechet_bound(curve.coarse, followed_.points) + followed_.sagitta_mm;
  out.points_off_mm = hold > 0.0 ? farthest_point_mm(curve.coarse, points, hold) : 0.0;
}

void SegmentCurve::fit(std::span<const Point2> points, const TubeOptions& options) {
  fit_tube(points, options, tube, curve.coarse);
  curve.offset.assign({0.0, curve.coarse.s.back()});
}

bool SegmentCurve::build(const PathPart& part, Shape shape, const CellSizes& sizes,
                         const PlanOptions& options, StopSegment& out) {
  const bool fitted = shape == Shape::kFitted;
  CurveOptions spec{options.curvature_ramp_mm,
                    shape == Shape::kPlain ? 0.0 : options.tolerance_mm,
                    0.0,
                    sizes,
                    part.yaw_rad,
                    part.given,
                    hold_mm(options)};
  bool hold_lines = fitted && spec.hold_mm > 0.0;
  const auto form = [&] {
    if (!fitted) return build_curve(part.points, spec, curve);
    const double radius = tube_radius_mm(spec, options);
    fit(part.points, {.radius_mm = radius,
                      .between_mm = std::max(radius, spec.tolerance_mm > 0.0 ? 0.0 : kSagittaMm),
                      .max_between_mm = max_between_mm(options),
                      .largest_mm = sizes.largest_mm,
                      .hold_lines = hold_lines});
  };
  follow(part);
  form();
  const double allowed = allowed_mm(shape, options);
  Reductions reductions(allowed);
  CurveOptions nearest = spec;
  double nearest_mm = kUnlimited;
  for (int tries = 0;; ++tries) {
    measure(part.points, options, out);
    const bool lines = hold_lines && tube.lines;
    if ((!holds(out, options) || (lines && !tube.converged)) && tries < kMaxHoldTries) {
      // a tube too narrow: some chord is no line after all
      hold_lines = false;
      if (!lines)
        spec.hold_mm *=
            std::clamp(kHoldAim * hold_mm(options) / out.points_off_mm, kMinReduction, kMaxReduction);
      form();
      continue;
    }
    if (out.deviation_mm <= allowed) break;
    if (out.deviation_mm < nearest_mm) {
      nearest = spec;
      nearest_mm = out.deviation_mm;
    }
    if (tries == kMaxDeviationTries) {
      spec = nearest;
      form();
      out.deviation_mm = nearest_mm;
      break;
    }
    const double share = std::clamp(kDeviationAim * allowed / out.deviation_mm, kMinReduction,
                                    fitted ? kMaxTubeReduction : kMaxReduction);
    if (fitted)
      spec.tolerance_mm *= share;
    else
      reductions.apply(share, tries == 0, spec);
    form();
  }
  return !fitted || holds(out, options);
}

}  // namespace firn::motion
