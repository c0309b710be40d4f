#include "studies/compare/study_lab.h"

#include <time.h>

#include <cmath>
#include <exception>
#include <limits>
#include <new>
#include <string_view>

#include "config/include.h"
#include "config/labs.h"
#include "core/deposition/height_change.h"
#include "core/grid/grid.h"
#include "core/grid/npy.h"
#include "core/grid/outline.h"
#include "plant/config/world_config.h"
#include "print/inputs/check_print.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "studies/compare/outline_metrics.h"
#include "studies/edge/edge_bound.h"

namespace firn {
namespace {

constexpr double kUm = 1e3;  // per mm
constexpr double kSecondsPerHour = 3600.0;

double thread_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

constexpr int kIterations = 8;   // row of the table: a lab of paths searches nothing
constexpr int kDropletRows = 2;  // rows at its end that a lab of paths has not

// Names of a study's metrics of the outline, beside those of the surface.
constexpr std::string_view kOutlineNames[] = {"overspill_pct", "first_ring_um",    "size_x_um",
                                              "size_y_um",     "missing_pct",      "misplaced_pct",
                                              "edge_width_um", "corner_radius_um", "inside_rms_um"};

const std::vector<report::StudyMetric>& metric_table() {
  static const std::vector<report::StudyMetric> table = [] {
    std::vector<report::StudyMetric> t = {
        {"rms_um", "um", "RMS of the true surface about the target", 3},
        {"std_um", "um", "roughness: standard deviation of the true error about its mean", 3},
        {"abs_mean_um", "um", "size of the mean error of the true surface", 3},
        {"mean_abs_um", "um", "mean of the absolute true error", 3},
        {"max_um", "um", "largest absolute true error of a cell", 2},
        {"layers", "", "layers printed", 1},
        {"droplets", "", "droplets fired", 0},
        {"print_s", "s", "simulated duration of the print", 1},
        {"iterations", "", "steps of the controller's search", 0},
    };
    for (const std::string_view name : kOutlineNames) t.push_back(outline_metric_of(outline_metric(name)));
    t.push_back({"passes", "", "passes of the stage that fired droplets", 0});
    t.push_back({std::string(kEdgeBound), "%",
                 "least overspill of any pattern at the same mean error, plant lu2015", 2});
    return t;
  }();
  return table;
}

// The same, and the hours of deposition and of measurement in a lab that stops to measure.
const std::vector<report::StudyMetric>& ice_metric_table() {
  static const std::vector<report::StudyMetric> table = [] {
    std::vector<report::StudyMetric> t = metric_table();
    t.erase(t.begin() + kIterations);
    t.resize(t.size() - kDropletRows);
    t[0].meaning = "RMS of the true surface about the nominal height after the last interval";
    t[5].meaning = "layers measured";
    t[6] = {"pulses", "", "pulses of both valves", 0};
    t.push_back({"worst_rms_um", "um", "largest RMS of the true surface after any interval", 2});
    t.push_back({"deposit_h", "h", "time of depositing", 2});
    t.push_back({"measure_h", "h", "time of measuring", 2});
    t.push_back({"time_h", "h", "time of depositing and measuring", 2});
    return t;
  }();
  return table;
}

std::vector<double> metrics_of(const MemoryPrintReport& r) {
  const ErrorStats& e = r.error;
  if (e.cells == 0)
    return std::vector<double>(metric_table().size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<double> values{e.rms_mm * kUm,
                             e.std_mm * kUm,
                             std::abs(e.mean_mm) * kUm,
                             e.mean_abs_mm * kUm,
                             std::max(std::abs(e.min_mm), std::abs(e.max_mm)) * kUm,
                             double(r.result.layers),
                             double(r.droplets),
                             r.node_s,
                             double(r.iterations)};
  for (const std::string_view name : kOutlineNames)
    values.push_back(outline_value(outline_metric(name), r.outline));
  values.push_back(double(r.passes));
  values.push_back(std::numeric_limits<double>::quiet_NaN());  // the bound, which add_edge_bound() computes
  return values;
}

std::vector<double> ice_metrics_of(const MemoryPrintReport& r) {
  std::vector<double> m = metrics_of(r);
  m.erase(m.begin() + kIterations);
  m.resize(m.size() - kDropletRows);
  double worst = std::numeric_limits<double>::quiet_NaN(), deposit_s = 0.0, measure_s = 0.0;
  for (const LayerTruth& l : r.series) {
    worst = std::isnan(worst) ? l.error.rms_mm : std::max(worst, l.error.rms_mm);
    deposit_s += l.deposit_s;
    measure_s += l.measure_s;
  }
  for (const double v : {worst * kUm, deposit_s / kSecondsPerHour, measure_s / kSecondsPerHour,
                         (deposit_s + measure_s) / kSecondsPerHour})
    m.push_back(v);
  return m;
}

const std::vector<report::StudyMetric>& line_metric_table() {
  static const std::vector<report::StudyMetric> table = {
      {"section_rms_pct", "%", "RMS of the lines' true section about the nominal one", 2},
      {"section_std_pct", "%", "standard deviation of the section along the lines", 2},
      {"section_mean_pct", "%", "size of the mean error of the section", 2},
      {"height_rms_pct", "%", "RMS of the lines' true height about the nominal one", 2},
      {"width_rms_um", "um", "RMS of the lines' true width about the nominal one", 2},
      {"visible_rms_um", "um", "RMS of the lines' true width at half contrast about the nominal one", 2},
      {"offset_rms_um", "um", "RMS of the distance of the lines' middles from the wanted ones", 2},
      {"start_um", "um", "largest error of a free start from the third layer on", 1},
      {"end_um", "um", "largest error of a free end from the third layer on", 1},
      {"overspray_pct", "%", "share of the section beside the line", 2},
      {"rms_um", "um", "RMS of the true surface about the target, over the middles of the lines", 3},
      {"max_um", "um", "largest absolute true error of a cell of the lines' middles", 2},
      {"gaps", "", "stations with less than 0.3 of the nominal section", 0},
      {"layers", "", "layers printed", 1},
      {"print_s", "s", "simulated duration of the print", 1},
      {"seen_width_um", "um", "RMS of the width in the camera's pictures about the nominal one", 2},
      {"seen_offset_um", "um", "RMS of the middles in the camera's pictures from the wanted ones", 2},
      {"seen_overspray_pct", "%", "share of the contrast beside the line, by the camera", 2},
      {"seen_gap_um", "um", "length without material, by the camera", 1},
      {"contour_max_um", "um", "largest distance of the followed from the planned path, any layer", 2},
      {"contour_rms_um", "um", "RMS of that distance along the path", 2},
      {"following_max_um", "um", "largest distance of the stage from the place planned for the time", 1},
      {"lag_ms", "ms", "largest time by which the stage is behind the plan", 2},
      {"switch_um", "um", "largest error of a place of the shutter along the followed path", 2},
      {"followed_offset_um", "um", "RMS of the lines' middles by the followed path from the wanted ones", 2},
  };
  return table;
}

constexpr double kMs = 1e3;  // per s

std::vector<double> line_metrics_of(const MemoryPrintReport& r) {
  const LineTruth& t = r.lines;
  if (t.stations == 0)
    return std::vector<double>(line_metric_table().size(), std::numeric_limits<double>::quiet_NaN());
  constexpr double kPercent = 100.0;
  return {kPercent * t.section_rms,
          kPercent * t.section_std,
          kPercent * std::abs(t.section_mean),
          kPercent * t.height_rms,
          kUm * t.width_rms_mm,
          kUm * t.visible_rms_mm,
          kUm * t.offset_rms_mm,
          kUm * t.worst_start_mm,
          kUm * t.worst_end_mm,
          kPercent * t.overspray,
          kUm * r.error.rms_mm,
          kUm * std::max(std::abs(r.error.min_mm), std::abs(r.error.max_mm)),
          t.gaps,
          double(r.result.layers),
          r.node_s,
          kUm * r.looks.width_rms_mm,
          kUm * r.looks.offset_rms_mm,
          kPercent * r.looks.overspray,
          kUm * r.looks.gap_mm,
          kUm * r.paths.contour_max_mm,
          kUm * r.paths.contour_rms_mm,
          kUm * r.paths.following_max_mm,
          kMs * r.paths.lag_max_s,
          kUm * r.paths.switch_max_mm,
          kUm * r.paths.offset_rms_mm};
}

void seed_all(Experiment& e, std::uint64_t seed) {
  e.plant.seed = seed;
  e.control.seed = seed;
}

// The bound is of Lu's model: of a world that is that model, with one ink.
void add_edge_bound(const Experiment& e, const Blobs& inputs, double mean_abs_mm,
                    std::vector<double>& metrics) {
  static const bool solver = has_edge_solver();
  if (!solver || e.plant.model != "lu2015" || e.geometry.solid.kind != "none" || prints_paths(e) ||
      prints_lines(e))
    return;
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  const Mask mask = mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask");
  const plant::Lu2015Params nature;  // the world's own heights, not the believed ones of [model]
  metrics.back() =
      100.0 * edge_bound(target, mask, {nature.h1_mm, nature.h2_mm, nature.h3_mm},
                         nature.keep_border ? deposition::Border::kKeep : deposition::Border::kLose,
                         mean_abs_mm);
}

StudyPrint print_once(const Experiment& e, const Blobs& inputs, bool edge_bound) {
  const bool paths = prints_paths(e), lines = prints_lines(e);
  StudyPrint p;
  const double began = thread_cpu_s();
  try {
    MemoryPrintOptions options;
    options.series = paths;
    options.outline = !lines;
    const MemoryPrintReport r = print_in_memory(full_product(), e, inputs, options);
    p.finished = !runs::can_go_on(r.result);
    p.outcome = r.result.outcome;
    p.reason = r.result.reason;
    p.metrics = study_metrics(e, r);
    if (edge_bound && r.error.cells > 0) add_edge_bound(e, inputs, r.error.mean_abs_mm, p.metrics);
    const double tolerance_um = tolerance_of_part_um(e);
    if (r.result.outcome == "out of tolerance")
      p.within = false;
    else if (tolerance_um > 0.0 && r.error.cells > 0)
      p.within = r.error.rms_mm * kUm <= tolerance_um;
    if (paths)
      for (const LayerTruth& l : r.series)
        p.profile.push_back({l.layer * e.ice.layer_height_mm, l.error.rms_mm * kUm});
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    p.outcome = "error";
    p.reason = error.what();
    p.metrics.assign(study_lab_of(e).metrics.size(), std::numeric_limits<double>::quiet_NaN());
  }
  p.cpu_s = thread_cpu_s() - began;
  return p;
}

}  // namespace

std::vector<double> study_metrics(const Experiment& e, const MemoryPrintReport& report) {
  if (prints_lines(e)) return line_metrics_of(report);
  return prints_paths(e) ? ice_metrics_of(report) : metrics_of(report);
}

const StudyLab& inkjet_study_lab() {
  static const StudyLab lab{metric_table(),
                            {"rms_um", "inside_rms_um", "std_um", "abs_mean_um", "max_um", "overspill_pct",
                             "missing_pct", "misplaced_pct", "first_ring_um", "size_x_um", "size_y_um",
                             "edge_width_um", "corner_radius_um", "print_s", "layers", "passes", "droplets"},
                            &seed_all,
                            [](const Experiment& e) { check_print(e, "in-process"); },
                            &print_once};
  return lab;
}

const StudyLab& ice_study_lab() {
  static const StudyLab lab{ice_metric_table(),
                            {"rms_um", "worst_rms_um", "abs_mean_um", "max_um", "overspill_pct",
                             "first_ring_um", "size_x_um", "size_y_um", "deposit_h", "measure_h"},
                            &seed_all,
                            [](const Experiment& e) { check_print(e, "in-process"); },
                            &print_once,
                            {"True RMS against height", "height_mm", "rms_um"}};
  return lab;
}

const StudyLab& aerosol_study_lab() {
  static const StudyLab lab{line_metric_table(),
                            {"section_rms_pct", "section_std_pct", "height_rms_pct", "width_rms_um",
                             "start_um", "end_um", "offset_rms_um", "overspray_pct", "print_s"},
                            &seed_all,
                            [](const Experiment& e) { check_print(e, "in-process"); },
                            &print_once};
  return lab;
}

double tolerance_of_part_um(const Experiment& experiment) {
  Experiment e = experiment;
  e.control.open_loop.layers = 0;
  return print_lab(full_product(), e).tolerance_um(e);
}

const StudyLab& study_lab_of(const Study& study, const std::filesystem::path& folder) {
  const auto texts = study_texts(study, folder);
  if (texts.empty()) return inkjet_study_lab();
  return study_lab_of(parse_experiment(texts, {}));
}

const StudyLab& study_lab_of(const Experiment& e) {
  if (prints_lines(e)) return aerosol_study_lab();
  return prints_paths(e) ? ice_study_lab() : inkjet_study_lab();
}

}  // namespace firn
