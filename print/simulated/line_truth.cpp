#include "print/simulated/line_truth.h"

#include <algorithm>
#include <cmath>

#include "core/control/lines/visible_width.h"
#include "core/grid/npy.h"
#include "core/path/job_codec.h"
#include "core/vision/lines.h"

namespace firn {
namespace {

constexpr int kSettled = 3;   // the first layer whose ends follow two that were measured
constexpr double kGap = 0.3;  // of the nominal section
constexpr double kLineEndClearance_mm = 0.5;

// The light that the ink takes, in place of heights [Beer and Lambert].
HeightMap contrast_of(HeightMap surface, double optical_depth_mm) {
  for (double& h : surface.cells) h = h > 0.0 ? 1.0 - std::exp(-h / optical_depth_mm) : 0.0;
  return surface;
}

}  // namespace

LineJudge::LineJudge(const Experiment& e, const Blobs& inputs)
    : width_mm_(e.aerosol.line_width_mm),
      optical_depth_mm_(e.plant.aerosol.optical_depth_mm),
      believed_depth_mm_(e.aerosol.optical_depth_mm),
      // The true surface has means over cells, the target values at their middles.
      target_(vision::seen_through(height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target"),
                                   e.grid.pitch_x_mm, e.grid.pitch_y_mm)),
      before_(e.grid, 0.0),
      newest_(e.grid, 0.0),
      wanted_layers_(e.aerosol.layers) {
  const PrintJob job = decode_job(blob(inputs, "job").bytes);
  stations_ = line_stations(job, e.aerosol.station_mm);
  ends_ = line_ends(job, kLineEndClearance_mm);
  for (const LineStation& s : stations_)
    layer_mm2_.push_back(e.aerosol.flow_mm3_s * e.aerosol.solids /
                         job.segments[std::size_t(s.segment)].speed_mm_s);
}

void LineJudge::take(int layer, const HeightMap& surface) {
  before_ = std::move(newest_);
  newest_ = surface;
  layer_ = layer;
  if (layer < std::min(kSettled, wanted_layers_)) return;
  HeightMap last = newest_;
  for (std::size_t c = 0; c < last.size(); ++c) last.cells[c] -= before_.cells[c];
  for (const LineEnd& end : ends_)
    if (const auto error = vision::measure_end(last, end, width_mm_, {})) {
      double& worst = end.start ? worst_start_mm_ : worst_end_mm_;
      worst = std::max(worst, std::abs(*error));
    }
}

void LineJudge::take(const line_plan_t& m) {
  if (m.layer < 2 || std::size_t(m.looks) != layer_mm2_.size()) return;
  const control::VisibleWidth nominal(width_mm_ / control::kWidthPerSigma, believed_depth_mm_);
  LineLooks l;
  double width = 0.0, offset = 0.0, overspray = 0.0, gap = 0.0;
  for (std::size_t s = 0; s < layer_mm2_.size(); ++s) {
    if (std::isnan(m.seen_width_mm[s])) continue;
    ++l.stations;
    const double off = m.seen_width_mm[s] - nominal.width_mm((m.layer - 1) * layer_mm2_[s]);
    width += off * off;
    offset += double(m.seen_offset_mm[s]) * m.seen_offset_mm[s];
    overspray += m.seen_overspray[s];
    gap += m.seen_gap_mm[s];
  }
  if (l.stations == 0) return;
  l.width_rms_mm = std::sqrt(width / l.stations);
  l.offset_rms_mm = std::sqrt(offset / l.stations);
  l.overspray = overspray / l.stations;
  l.gap_mm = gap;
  looks_ = l;
}

void LineJudge::take(const path_report_t& m) {
  if (m.samples == 0) return;
  const double before = paths_.layers++, n = paths_.layers;
  const auto largest = [](double& most, double value) {
    if (!(most >= value)) most = std::isnan(value) ? most : value;
  };
  const auto mean_square = [&](double& rms, double value) {
    const double sum = std::isnan(rms) ? 0.0 : before * rms * rms;
    rms = std::sqrt((sum + value * value) / n);
  };
  largest(paths_.contour_max_mm, m.contour_max_mm);
  largest(paths_.following_max_mm, m.following_max_mm);
  largest(paths_.lag_max_s, m.lag_max_s);
  largest(paths_.switch_max_mm, m.switch_max_mm);
  mean_square(paths_.contour_rms_mm, m.contour_rms_mm);
  mean_square(paths_.offset_rms_mm, m.offset_rms_mm);
}

LineTruth LineJudge::result() const {
  LineTruth t;
  double overspray = 0.0, visible = 0.0;
  int looks = 0;
  const HeightMap seen = contrast_of(newest_, optical_depth_mm_),
                  wanted = contrast_of(target_, optical_depth_mm_);
  for (const LineStation& s : stations_) {
    const auto line = vision::measure_line(newest_, s, {}), nominal = vision::measure_line(target_, s, {});
    if (!line || !nominal) continue;
    const auto look = vision::measure_line(seen, s, {}), look_nominal = vision::measure_line(wanted, s, {});
    if (look && look_nominal && std::isfinite(look->width_mm)) {
      const double off = look->width_mm - look_nominal->width_mm;
      visible += off * off;
      ++looks;
    }
    const double section = line->area_mm2 / nominal->area_mm2 - 1.0;
    if (section + 1.0 < kGap) t.gaps += 1.0;
    if (std::isnan(line->width_mm)) continue;
    ++t.stations;
    const double height = line->height_mm / nominal->height_mm - 1.0,
                 width = line->width_mm - nominal->width_mm;
    t.section_rms += section * section;
    t.section_mean += section;
    t.height_rms += height * height;
    t.width_rms_mm += width * width;
    t.width_mean_mm += line->width_mm;
    t.offset_rms_mm += line->offset_mm * line->offset_mm;
    overspray += line->overspray;
  }
  const double n = std::max(1, t.stations);
  t.section_mean /= n;
  t.section_std = std::sqrt(std::max(0.0, t.section_rms / n - t.section_mean * t.section_mean));
  t.section_rms = std::sqrt(t.section_rms / n);
  t.height_rms = std::sqrt(t.height_rms / n);
  t.width_rms_mm = std::sqrt(t.width_rms_mm / n);
  t.width_mean_mm /= n;
  t.offset_rms_mm = std::sqrt(t.offset_rms_mm / n);
  t.overspray = overspray / n;
  t.visible_rms_mm = std::sqrt(visible / std::max(1, looks));
  t.worst_start_mm = worst_start_mm_;
  t.worst_end_mm = worst_end_mm_;
  return t;
}

}  // namespace firn
