#include "runs/folder/verdict.h"

#include <fmt/core.h>

#include <cmath>

#include "core/grid/outline.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"

namespace firn::runs {
namespace {

constexpr double kPercent = 100.0, kUm = 1e3;  // per mm

// "edge of the measured surface: 0.21 mm wide from 10 to 90 % of the height; size error 0.44 mm along x,
// ..."; empty: not known.
std::string edge_words(const OutlineStats& o, const LabWords& lab) {
  const auto length = [&](double mm) {
    return (std::signbit(mm) ? "-" : "") + lab.length(std::abs(mm) * kUm);
  };
  std::string text;
  const auto add = [&](double mm, const std::string& words) {
    if (std::isfinite(mm)) text += (text.empty() ? "edge of the measured surface: " : "; ") + words;
  };
  add(o.edge_width_mm, length(o.edge_width_mm) + " wide from 10 to 90 % of the height");
  if (std::isfinite(o.size_error_y_mm))
    add(o.size_error_x_mm, "size error " + std::string(o.cut ? "at least " : "") + length(o.size_error_x_mm) +
                               " along x, " + length(o.size_error_y_mm) + " along y");
  add(o.first_ring_mm, "first ring " + length(o.first_ring_mm) + " high");
  add(o.corner_radius_mm, "corners of radius " + length(o.corner_radius_mm));
  return text.empty() ? "" : text + "\n";
}

}  // namespace

std::string verdict_words(const RunResult& r, const LabWords& lab) {
  if (can_go_on(r)) return "";
  const std::optional<bool> within = within_tolerance(r);
  if (within == false) return "OUT OF TOLERANCE: " + for_people(r.reason);
  if (within)
    return fmt::format("within tolerance: RMS {} of the last map, at most {}", lab.length(r.error->rms_um),
                       lab.length(*r.tolerance_um));
  if (r.status == kFailed) return "NOT JUDGED: " + for_people(r.reason);
  if (r.error) return "no target";
  return r.part ? "not judged: heights were not measured" : "not judged";  // an older program told no error
}

std::string end_words(const RunResult& r) {
  return r.outcome + (r.reason.empty() ? "" : ": " + for_people(r.reason));
}

std::string part_words(const PrintedPart& p) {
  return fmt::format("{}, {} x {} x {} mm", p.name, for_people(p.size_mm[0]), for_people(p.size_mm[1]),
                     for_people(p.size_mm[2]));
}

std::string use_words(const PrintUse& use, const LabWords& lab) {
  if (use.amount == 0 && use.volume_mm3 == 0.0) return "";
  std::string hours;
  for (const auto& [node, i] : use.instruments)
    if (i.hours > 0.0)
      hours += (hours.empty() ? "; " : ", ") + node + " " + time_for_people(i.hours * kHour_s);
  return for_people(use.volume_mm3) + " mm^3 in " + std::to_string(use.amount) + " " +
         std::string(lab.amount) + hours;
}

std::string result_lines(const RunResult& r, const LabWords& lab) {
  std::string text;
  if (r.part) text += "part: " + part_words(*r.part) + "\n";
  if (const auto& e = r.error) {
    text += fmt::format("measured surface against {}: mean {}{}, RMS {}, std {}\n", lab.reference,
                        std::signbit(e->mean_um) ? "-" : "+", lab.length(std::abs(e->mean_um)),
                        lab.length(e->rms_um), lab.length(e->std_um));
    if (e->rms_inside_um > 0.0 || e->rms_rim_um > 0.0)
      text += fmt::format("RMS inside {}, on the rim {}\n", lab.length(e->rms_inside_um),
                          lab.length(e->rms_rim_um));
  }
  if (r.overspill_percent) {
    text += "overspill of the measured surface: " + for_people(*r.overspill_percent) +
            " % of the part's volume lies beside it";
    if (r.outline && std::isfinite(r.outline->missing))
      text += ", " + for_people(r.outline->missing * kPercent) + " % is missing inside";
    text += "\n";
  }
  if (r.outline) text += edge_words(*r.outline, lab);
  if (const std::string used = r.use ? use_words(*r.use, lab) : ""; !used.empty())
    text += "used: " + used + "\n";
  if (!r.audit.empty()) text += "audit: " + r.audit + "\n";
  return text;
}

}  // namespace firn::runs
