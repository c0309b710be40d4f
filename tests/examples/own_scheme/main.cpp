// own_scheme prints a cylinder under a feedback scheme of its own and in open loop, on the height-change model, and
// says how flat each is: RMS errors in um.
#include <algorithm>
#include <cstdio>

#include "core/control/controller.h"
#include "core/control/prediction.h"
#include "core/deposition/height_change.h"
#include "core/grid/shapes.h"

using namespace firn;

namespace {

/// Prints wherever half a layer is lacking.
class Fill final : public control::LayerControllerBase {
 public:
  explicit Fill(const control::Setup& setup) : setup_(setup), predict_(setup) {}

  control::Decision decide(const control::Measurement& m) override {
    control::check(m, setup_);
    const HeightMap height = control::known_heights(m);
    control::Decision d;
    d.drops = DropletPattern(setup_.grid);
    for (std::size_t c = 0; c < height.size(); ++c)
      d.drops.cells[c] = setup_.mask.cells[c] &&
                         height.cells[c] + 0.5 * setup_.model.layer_height_mm() < setup_.target.cells[c];
    predict_.score(d, height, 1.0);
    d.kind = d.drops.total() > 0 ? control::Decision::Kind::kPrint : control::Decision::Kind::kEnd;
    return d;
  }

 private:
  control::Setup setup_;
  control::Predictor predict_;
};

double rms_um(const control::Setup& setup, control::LayerController& scheme) {
  deposition::HeightChange<1> nature(setup.grid, deposition::stencil_of(setup.model), setup.border);
  HeightMap height(setup.grid, 0.0);
  for (int layer = 0; layer < 200; ++layer) {
    const control::Decision d = scheme.decide({height, layer, 0, 0.0});
    if (d.kind != control::Decision::Kind::kPrint) break;
    nature.deposit(height, d.drops);
  }
  return 1000.0 * error_stats(height, setup.target, setup.mask).rms_mm;
}

}  // namespace

int main() {
  const GridSpec grid{20, 20, 0.263256, 0.263256, 0.0, 0.0};
  ShapeSpec cylinder;
  cylinder.diameter_mm = 4.6;
  cylinder.height_mm = 0.1;
  const Target target = make_shape(cylinder, grid);
  const control::Setup setup{grid, target.height, target.mask, {0.0044, 0.0006, 0.0002}};
  control::ControlOptions options;
  options.scheme = "open_loop";
  Fill fill(setup);
  std::printf("{\"open_loop_um\": %.3f, \"fill_um\": %.3f}\n", rms_um(setup, *make_controller(setup, options)),
              rms_um(setup, fill));
}
