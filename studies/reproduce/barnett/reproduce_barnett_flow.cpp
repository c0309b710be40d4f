// Computes Fig. 6-1 of Barnett (2012): flow of a micro-solenoid valve against its frequency, weighed in the
// simulated ice lab as 6.1 describes it.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "config/include.h"
#include "print/inputs/ice_inputs.h"
#include "report/draw/charts.h"
#include "runtime/source_folder.h"
#include "studies/calibrate/lab_calibrations.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

constexpr const char* kMachine = "[machine]\nname = \"cobra600\"\n";

}  // namespace

void reproduce_barnett_flow(Reproduction& to) {
  to.note(
      "Fig. 6-1 prints no numbers in the text. The valve for water of the ice lab is fired at 20 frequencies "
      "into a cup "
      "on a balance (firn calibrate flow-curve); the drop's flow at low frequency is drawn on as the "
      "proportional line. "
      "The plant's share and time of recovery after a pulse were chosen for this figure.");
  const std::filesystem::path folder = source_folder() / "labs";
  Experiment lab = load_experiment(folder / "ice-cobra600.toml", {"ice.mesh=\"none.stl\""});
  LabCalibrationOptions options;
  options.repeats = to.quick() ? 2 : 0;
  options.progress = [&](double share) { to.progress(share, "weighing drops"); };
  const LabCalibration found = calibrate_flow_curve(lab, kMachine, options);
  const std::vector<double>&hz = found.keys.at(0).value, &flow = found.keys.at(1).value;
  const double proportional = flow.at(0) / hz.at(0);  // mm3 a drop, at the lowest frequency
  const auto below = [&](double at_hz) {
    const std::size_t k = std::size_t(
        std::min_element(hz.begin(), hz.end(),
                         [&](double a, double b) { return std::abs(a - at_hz) < std::abs(b - at_hz); }) -
        hz.begin());
    return 100.0 * (1.0 - flow[k] / (proportional * hz[k]));
  };
  const double middle = below(0.5 * hz.back()), top = below(hz.back());
  to.row(
      ReproduceRow("barnett.fig-6-1.shortfall",
                   fmt::format("Fig. 6-1: flow below the proportional one at {:.0f} and {:.0f} Hz, weighed",
                               0.5 * hz.back(), hz.back()),
                   "", fmt::format("{:.1f} % and {:.1f} %", middle, top))
          .prints(
              "this is not the case", "p. 135, Fig. 6-1",
              "it is nominally expected that flow rate will be proportional to valve frequency. In practice, "
              "however, this is not the case")
          .holds(top > 5.0 && top > middle && std::is_sorted(flow.begin(), flow.end()),
                 "more than 5 % and growing; flow ascends")
          .fitted("share and time of recovery after a pulse of the plant's line, to Fig. 6-1"));
  report::Series weighed{"weighed", hz, flow, 0, true},
      line{"proportional", {0.0, hz.back()}, {}, report::Series::kReference};
  line.y = {0.0, proportional * hz.back()};
  to.picture(
      {"fig-6-1", "Fig. 6-1: flow against frequency of the valve for water",
       report::line_chart(
           {weighed, line},
           {.title = "Fig. 6-1", .x_name = "frequency [Hz]", .y_name = "flow [mm3/s]", .from_zero = true})});
}

}  // namespace firn
