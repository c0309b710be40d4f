// Level feedback that learns a droplet's height from the rise of the last layers.
#pragma once

#include <array>

#include "tests/docs/level_controller.h"

namespace firn::control {

inline constexpr std::array kLearningOptions{
    ExtraOption{"learning_rate", 0.3, "", above(0, 1), "share of the newest layer in the learned rise"}};

class LearningController final : public LayerControllerBase {
 public:
  LearningController(const Setup& setup, const ControlOptions& options)
      : setup_(setup), rate_(options.extra.number("learning_rate")) {
    check_extra("learning", kLearningOptions, options.extra);  // throws and names the option
  }

  Decision decide(const Measurement& m) override {
    check(m, setup_);
    if (m.layer > after_.layer) before_ = after_;  // else: measured again, as if the first time had not been
    const double mean_mm = error_stats(known_heights(m), HeightMap(setup_.grid), setup_.mask).mean_mm;
    after_ = {m.layer, mean_mm, 0.0, before_.gain};
    if (before_.drops > 0.0) {
      const double foretold_mm = before_.drops * setup_.model.layer_height_mm();
      after_.gain += rate_ * ((mean_mm - before_.mean_mm) / foretold_mm - before_.gain);
    }
    Setup learned = setup_;
    learned.model.h1_mm *= after_.gain;
    learned.model.h2_mm *= after_.gain;
    learned.model.h3_mm *= after_.gain;
    Decision d = LevelController(learned, {}).decide(m);
    after_.drops = double(d.drops.total()) / double(setup_.mask.count());
    return d;
  }

 private:
  struct Memory {
    int layer = -1;
    double mean_mm = 0.0, drops = 0.0;  // per cell of the part
    double gain = 1.0;                  // measured rise over the model's
  };
  Setup setup_;
  double rate_;
  Memory before_, after_;
};

}  // namespace firn::control
