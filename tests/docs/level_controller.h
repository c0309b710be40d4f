// Level feedback: raise the lowest cells first, so that the surface comes up level.
#pragma once

#include <algorithm>

#include "core/control/controller.h"
#include "core/control/prediction.h"

namespace firn::control {

class LevelController final : public LayerControllerBase {
 public:
  LevelController(const Setup& setup, const ControlOptions&) : setup_(setup), predict_(setup) {}

  Decision decide(const Measurement& m) override {
    check(m, setup_);  // grid, finite heights: throws and names the cell
    const HeightMap height = known_heights(m);
    double lowest_mm = 1e9;  // of the cells that still need ink
    for (std::size_t c = 0; c < height.size(); ++c)
      if (needs_ink(height, c)) lowest_mm = std::min(lowest_mm, height.cells[c]);

    Decision d;
    d.drops = DropletPattern(setup_.grid);
    // One layer above the lowest: no higher cell gets a droplet.
    for (std::size_t c = 0; c < height.size(); ++c)
      d.drops.cells[c] = needs_ink(height, c) && height.cells[c] < lowest_mm + setup_.model.layer_height_mm();
    predict_.score(d, height, 1.0);  // objective of the plan and of printing nothing
    const bool helps = d.drops.total() > 0 && d.objective_mm < d.objective_none_mm;
    d.kind = helps ? Decision::Kind::kPrint : Decision::Kind::kEnd;
    d.reason = helps ? "raises the lowest cells" : "no droplet brings the surface closer to the target";
    if (!helps) d.drops = DropletPattern(setup_.grid);
    return d;
  }

 private:
  bool needs_ink(const HeightMap& height, std::size_t c) const {
    return setup_.mask.cells[c] &&
           height.cells[c] + 0.5 * setup_.model.layer_height_mm() < setup_.target.cells[c];
  }
  Setup setup_;
  Predictor predict_;
};

}  // namespace firn::control
