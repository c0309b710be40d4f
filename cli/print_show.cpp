#include "cli/print_show.h"

#include <fmt/core.h>

#include <cmath>

#include "files/json.h"
#include "print/exit_codes.h"

namespace firn {
namespace {

constexpr double kUm = 1e3;                               // per mm
constexpr std::string_view kSpoilt = "out of tolerance";  // an outcome

std::string length(double um, bool in_mm) {
  return in_mm ? fmt::format("{:.3f} mm", um / kUm) : fmt::format("{:.2f} um", um);
}

std::string verdict_text(const PrintSummary& s) {
  if (s.result.outcome == kSpoilt) return "OUT OF TOLERANCE: " + s.result.reason + "\n";
  const std::optional<bool> within = within_tolerance(s);
  const std::string limit = length(s.tolerance_um, s.words.in_mm) + (s.tolerance_asked ? "" : ", one layer");
  if (within)
    return fmt::format("{}: RMS {} of the last map, {} {}\n",
                       *within ? "within tolerance" : "OUT OF TOLERANCE", length(s.rms_um, s.words.in_mm),
                       *within ? "at most" : "more than", limit);
  return s.tolerance_asked && !can_go_on(s.result)
             ? "tolerance: nothing was measured that it could be judged by\n"
             : "";
}

}  // namespace

double usual_tolerance_um(const Experiment& e) { return print_lab(e).tolerance_um(e); }

std::optional<bool> within_tolerance(const PrintSummary& s) {
  if (s.tolerance_um == 0.0 || !s.measured || can_go_on(s.result)) return std::nullopt;
  return s.rms_um <= s.tolerance_um && s.result.outcome != kSpoilt;
}

int exit_code(const PrintSummary& s) {
  if (s.result.status != kOk) return s.result.status;
  const std::optional<bool> within = within_tolerance(s);
  if (within) return *within ? kOk : kOutOfTolerance;
  return s.tolerance_asked ? kFailed : kOk;
}

std::string print_text(const PrintSummary& s) {
  std::string text = fmt::format("{}: {} after {} layers and {} {} ({})\n", s.scheme, s.result.outcome,
                                 s.result.layers, s.droplets, s.words.amount, s.result.reason);
  if (s.measured)
    text += fmt::format(
        "measured surface against {}: mean {}, RMS {}, std {}\n", s.words.reference,
        (std::signbit(s.mean_error_um) ? "-" : "+") + length(std::abs(s.mean_error_um), s.words.in_mm),
        length(s.rms_um, s.words.in_mm), length(s.std_um, s.words.in_mm));
  if (s.rms_inside_um > 0.0 || s.rms_rim_um > 0.0)
    text += fmt::format("RMS inside {}, on the rim {}\n", length(s.rms_inside_um, s.words.in_mm),
                        length(s.rms_rim_um, s.words.in_mm));
  if (s.rows_lost > 0)
    text += fmt::format("{} ROWS of the scans were LOST; {} cells of the last map are not measured\n",
                        s.rows_lost, s.cells_guessed);
  text += fmt::format("{:.1f} s of wall time, {:.1f} s of node time; run folder {}\n", s.wall_s, s.node_s,
                      s.folder);
  if (!can_go_on(s.result)) return text + verdict_text(s);
  return text + fmt::format("to go on: {}firn print --resume {}\n",
                            s.deleted ? "bring the run folder back, then " : "", s.folder);
}

std::string print_json(const PrintSummary& s) {
  using Json = nlohmann::ordered_json;
  const std::optional<bool> within = within_tolerance(s);
  const Json j = {{"run", s.folder},
                  {"scheme", s.scheme},
                  {"outcome", s.result.outcome},
                  {"status", exit_code(s)},
                  {"layers", s.result.layers},
                  {std::string(s.words.amount), s.droplets},
                  {"mean_error_um", s.mean_error_um},
                  {"rms_um", s.rms_um},
                  {"std_um", s.std_um},
                  {"rms_inside_um", s.rms_inside_um},
                  {"rms_rim_um", s.rms_rim_um},
                  {"rows_lost", s.rows_lost},
                  {"cells_guessed", s.cells_guessed},
                  {"tolerance_um", s.tolerance_um > 0.0 ? Json(s.tolerance_um) : Json(nullptr)},
                  {"within_tolerance", within ? Json(*within) : Json(nullptr)},
                  {"wall_s", s.wall_s},
                  {"node_s", s.node_s},
                  {"reason", s.result.reason}};
  return j.dump(2) + "\n";
}

}  // namespace firn
