#include "cli/print_show.h"

#include <fmt/core.h>

#include <cmath>
#include <string>

#include "core/grid/grid.h"
#include "core/grid/outline.h"
#include "core/options/for_people.h"
#include "files/json.h"
#include "runs/folder/verdict.h"

namespace firn {

std::string last_line(const runs::RunResult& result, const LabWords& words, const std::string& folder) {
  const std::string verdict = runs::verdict_words(result, words);
  return (verdict.empty() ? "to go on: firn print --resume " + folder : verdict) + "\n";
}

std::string print_text(const PrintSummary& s) {
  const std::string verdict = verdict_words(s.result, s.words);
  const bool said_below = verdict.find(for_people(s.result.reason)) != verdict.npos;
  std::string text = fmt::format("{}: {} after {} and {} {}{}\n", s.scheme, s.result.outcome,
                                 counted(std::uint64_t(s.result.layers), "layer"), s.droplets, s.words.amount,
                                 said_below ? "" : " (" + for_people(s.result.reason) + ")");
  text += result_lines(s.result, s.words);
  if (s.rows_lost > 0)
    text += fmt::format("LOST: {} of the scans; {} of the last map not measured\n",
                        counted(std::uint64_t(s.rows_lost), "row"),
                        counted(std::uint64_t(s.cells_guessed), "cell"));
  text += fmt::format("{} s of wall time, {} s of node time; run folder {}\n", for_people(s.wall_s),
                      for_people(s.node_s), s.folder);
  if (s.deleted && verdict.empty()) text += "bring the run folder back first\n";
  return text + last_line(s.result, s.words, s.folder);
}

std::string print_json(const PrintSummary& s) {
  using Json = nlohmann::ordered_json;
  const std::optional<bool> within = within_tolerance(s.result);
  const runs::MapError error = s.result.error.value_or(runs::MapError{});
  Json j = {
      {"run", s.folder},
      {"scheme", s.scheme},
      {"outcome", s.result.outcome},
      {"status", s.result.status},
      {"layers", s.result.layers},
      {std::string(s.words.amount), s.droplets},
      {"mean_error_um", error.mean_um},
      {"rms_um", error.rms_um},
      {"std_um", error.std_um},
      {"rms_inside_um", error.rms_inside_um},
      {"rms_rim_um", error.rms_rim_um},
      {"rows_lost", s.rows_lost},
      {"cells_guessed", s.cells_guessed},
      {"tolerance_um", s.result.tolerance_um ? Json(*s.result.tolerance_um) : Json(nullptr)},
      {"within_tolerance", within ? Json(*within) : Json(nullptr)},
      {"part", s.result.part ? Json(s.result.part->name) : Json(nullptr)},
      {"size_mm", s.result.part ? Json(s.result.part->size_mm) : Json(nullptr)},
      {"overspill_percent", s.result.overspill_percent ? Json(*s.result.overspill_percent) : Json(nullptr)},
      {"audit", s.result.audit},
      {"verdict", verdict_words(s.result, s.words)},
      {"wall_s", s.wall_s},
      {"node_s", s.node_s},
      {"reason", s.result.reason}};
  for (const OutlineMetric& m : kOutlineMetrics)
    if (m.value != &OutlineStats::overspill) {
      const double v = s.result.outline ? (*s.result.outline).*m.value * m.factor : kNotMeasured;
      j[std::string(m.name)] = std::isfinite(v) ? Json(v) : Json(nullptr);
    }
  return j.dump(2) + "\n";
}

}  // namespace firn
