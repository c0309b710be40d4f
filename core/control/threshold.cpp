#include "core/control/threshold.h"

#include <algorithm>

#include "core/control/rim_inset.h"

namespace firn::control {
namespace {

const ThresholdOptions& checked_threshold(const ThresholdOptions& o) {
  check_options("threshold", kThresholdOptions, o);
  return o;
}

}  // namespace

Threshold::Threshold(const Setup& setup, const ControlOptions& options)
    : setup_(setup),
      dh_mm_(checked_threshold(options.threshold).layer_height_mm),
      threshold_mm_(options.threshold.threshold_mm),
      inset_(inset_places(setup, options.rim_inset)),
      predict_(setup) {
  if (dh_mm_ == 0.0) dh_mm_ = setup.model.layer_height_mm();
  if (threshold_mm_ == 0.0) threshold_mm_ = 0.5 * dh_mm_;
}

void Threshold::use_options(const ControlOptions& options) {
  const double mm = checked_threshold(options.threshold).threshold_mm;
  threshold_mm_ = mm == 0.0 ? 0.5 * dh_mm_ : mm;
}

Decision Threshold::decide(const Measurement& m) {
  check(m, setup_);
  Decision d;
  d.drops = DropletPattern(setup_.grid);
  bool growing = false;  // the reference of some cell is below its target
  for (std::size_t c = 0; c < d.drops.size(); ++c) {
    if (!setup_.mask.cells[c]) continue;
    const double target = setup_.target.cells[c], reference = std::min(double(m.layer + 1) * dh_mm_, target);
    d.drops.cells[c] = reference - m.height.cells[c] > threshold_mm_;
    growing = growing || double(m.layer) * dh_mm_ < target;
  }
  const std::int64_t tagged = d.drops.total();
  const HeightMap height = known_heights(m);
  d.materials = materials_at(setup_, height);
  d.offsets = inset_;
  predict_.score(d, height, 1.0);
  if (!growing && tagged == 0) {
    end_print(d, "the nominal height is reached and no cell is short by more than the threshold");
    return d;
  }
  d.kind = Decision::Kind::kPrint;
  d.reason = std::to_string(tagged) + " cells are short of layer " + std::to_string(m.layer + 1) +
             " by more than the threshold";
  return d;
}

}  // namespace firn::control
