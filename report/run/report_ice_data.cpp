#include "report/run/report_ice_data.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/path/path.h"
#include "core/slice/coverage/footprint.h"
#include "firn/control_surface_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/path_job_t.hpp"
#include "firn/pulse_list_t.hpp"
#include "firn/trajectory_t.hpp"
#include "lcmtypes/convert.h"
#include "runs/read/truth.h"

namespace firn::report {
namespace {

constexpr double kLongestCurve_s = 8.0;  // more than some hundred pulses are a blur
// The arm of the lab; speeds in a picture need no better [Table 2-1].
constexpr double kLink1_mm = 325.0, kLink2_mm = 275.0;

double nominal_mm(const slice::LayerPaths& l) { return l.z * geometry::kMmPerUnit; }

IcePathCurve curve_of(const path_job_t& job, const trajectory_t& t, const std::vector<pulse_list_t>& lists) {
  IcePathCurve c;
  c.path = job.path;
  c.layer = job.layer;
  double x0 = 0, y0 = 0;
  for (int n = 0; n < t.samples && t.axes >= 2; ++n) {
    const double a = t.position[std::size_t(n * t.axes)], b = a + t.position[std::size_t(n * t.axes + 1)];
    const double x = kLink1_mm * std::cos(a) + kLink2_mm * std::cos(b),
                 y = kLink1_mm * std::sin(a) + kLink2_mm * std::sin(b);
    if (n > 0) {
      c.time_s.push_back((n - 0.5) * t.tick_s);
      c.speed_mm_s.push_back(std::hypot(x - x0, y - y0) / t.tick_s);
    }
    x0 = x;
    y0 = y;
  }
  for (const pulse_list_t& l : lists)
    for (std::size_t k = 1; k < l.tick.size(); ++k) {
      const double gap_s = (l.tick[k] - l.tick[k - 1]) * l.tick_s;
      c.pulse_s.push_back(l.start_s + 0.5 * (l.tick[k] + l.tick[k - 1]) * l.tick_s);
      c.frequency_hz.push_back(gap_s > 0.0 ? 1.0 / gap_s : 0.0);
    }
  return c;
}

void read_curve(const runs::RunMessages& messages, IceData& data) {
  path_job_t best{};
  messages.each<path_job_t>(channels::kPathJob.name, [&](const path_job_t& j) {
    if (PathKind(j.kind) == PathKind::kMeasurement || j.material != 0 || j.pulses < 2 ||
        j.duration_s > kLongestCurve_s)
      return;
    if (j.layer > best.layer || (j.layer == best.layer && j.length_mm > best.length_mm)) best = j;
  });
  if (best.path == 0) return;
  std::vector<pulse_list_t> lists;
  messages.each<pulse_list_t>(channels::kPulseList.name, [&](const pulse_list_t& l) {
    if (l.path == best.path) lists.push_back(l);
  });
  messages.each<trajectory_t>(channels::kTrajectory.name, [&](const trajectory_t& t) {
    if (t.path == best.path) data.curve = curve_of(best, t, lists);
  });
}

void read_truth(const std::filesystem::path& run, IceData& data) {
  runs::each_truth(run, [&](std::int32_t layer, HeightMap field) {
    for (IceInterval& i : data.intervals)
      if (i.layer == layer) i.truth = replay::cell_means(field, i.height.spec);
    data.field = std::move(field);
  });
}

OutlineStats outline_of(const HeightMap& field, const replay::NominalPart& whole) {
  return outline_stats(replay::cell_means(field, whole.target.spec), whole.target, whole.mask);
}

}  // namespace

IceData read_ice_data(const std::filesystem::path& run, const runs::RunMessages& messages,
                      std::span<const std::byte> bytes) {
  const slice::PrintPaths paths = slice::decode_print_paths(bytes);
  IceData data;
  std::map<std::int32_t, IceInterval> intervals;
  messages.each<height_map_t>(channels::kHeightMap.name, [&](const height_map_t& m) {
    const slice::LayerPaths* layer = slice::find_layer(paths, m.layer);
    if (!layer) return;
    IceInterval i;
    i.layer = m.layer;
    i.nominal_mm = nominal_mm(*layer);
    i.height = height_of(m);
    i.footprint = replay::judged_cells(*layer, i.height.spec);
    intervals.insert_or_assign(m.layer, std::move(i));
  });
  messages.each<control_surface_t>(channels::kControlSurface.name, [&](const control_surface_t& m) {
    if (const auto i = intervals.find(m.layer); i != intervals.end())
      i->second.saturated_fraction = m.saturated_fraction;
  });
  for (auto& [layer, interval] : intervals) data.intervals.push_back(std::move(interval));
  read_curve(messages, data);
  read_truth(run, data);
  data.nominal = replay::nominal_part(paths, replay::kOutlineCell_mm, replay::kOutlineMargin_mm,
                                      replay::NominalOf::kPartAndScaffold);
  if (data.field) data.outline = outline_of(*data.field, data.nominal);
  return data;
}

}  // namespace firn::report
