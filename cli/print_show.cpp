#include "cli/print_show.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "print/exit_codes.h"

namespace firn {
namespace {

constexpr double kUm = 1e3;  // per mm

std::string length(double um, bool ice) {
  return ice ? fmt::format("{:.3f} mm", um / kUm) : fmt::format("{:.2f} um", um);
}

std::string verdict_text(const PrintSummary& s) {
  const std::optional<bool> within = within_tolerance(s);
  const std::string limit = length(s.tolerance_um, s.ice) + (s.tolerance_asked ? "" : ", one layer");
  if (within)
    return fmt::format("{}: RMS {} of the last map, {} {}\n",
                       *within ? "within tolerance" : "OUT OF TOLERANCE", length(s.rms_um, s.ice),
                       *within ? "at most" : "more than", limit);
  return s.tolerance_asked && !can_go_on(s.result)
             ? "tolerance: nothing was measured that it could be judged by\n"
             : "";
}

}  // namespace

double usual_tolerance_um(const Experiment& e) {
  const std::string& scheme = e.control.scheme;
  if (is_ice(e)) return e.ice.layer_height_mm * kUm;
  if (scheme == "pattern" || scheme == "registration" ||
      (scheme == "open_loop" && e.control.open_loop.layers > 0))
    return 0.0;
  return (e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm) * kUm;
}

std::optional<bool> within_tolerance(const PrintSummary& s) {
  if (s.tolerance_um == 0.0 || !s.measured || can_go_on(s.result)) return std::nullopt;
  return s.rms_um <= s.tolerance_um;
}

int exit_code(const PrintSummary& s) {
  return s.tolerance_asked && s.result.status == kOk && !within_tolerance(s).value_or(false)
             ? int(kFailed)
             : s.result.status;
}

std::string print_text(const PrintSummary& s) {
  std::string text = fmt::format("{}: {} after {} layers and {} {} ({})\n", s.scheme, s.result.outcome,
                                 s.result.layers, s.droplets, s.ice ? "pulses" : "droplets", s.result.reason);
  if (s.measured && s.ice)
    text += fmt::format(
        "measured surface against the nominal height: mean {:+.3f} mm, RMS {:.3f} mm, std {:.3f} mm\n",
        s.mean_error_um / kUm, s.rms_um / kUm, s.std_um / kUm);
  else if (s.measured)
    text += fmt::format("measured surface against target: mean {:+.2f} um, RMS {:.2f} um, std {:.2f} um\n",
                        s.mean_error_um, s.rms_um, s.std_um);
  text += fmt::format("{:.1f} s of wall time, {:.1f} s of node time; run folder {}\n", s.wall_s, s.node_s,
                      s.folder);
  return text + (can_go_on(s.result) ? fmt::format("to go on: firn print --resume {}\n", s.folder)
                                     : verdict_text(s));
}

std::string print_json(const PrintSummary& s) {
  using Json = nlohmann::ordered_json;
  const std::optional<bool> within = within_tolerance(s);
  const Json j = {{"run", s.folder},
                  {"scheme", s.scheme},
                  {"outcome", s.result.outcome},
                  {"status", exit_code(s)},
                  {"layers", s.result.layers},
                  {s.ice ? "pulses" : "droplets", s.droplets},
                  {"mean_error_um", s.mean_error_um},
                  {"rms_um", s.rms_um},
                  {"std_um", s.std_um},
                  {"tolerance_um", s.tolerance_um > 0.0 ? Json(s.tolerance_um) : Json(nullptr)},
                  {"within_tolerance", within ? Json(*within) : Json(nullptr)},
                  {"wall_s", s.wall_s},
                  {"node_s", s.node_s},
                  {"reason", s.result.reason}};
  return j.dump(2) + "\n";
}

}  // namespace firn
