#include "procs/surface_mapper/node.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "config/labs.h"
#include "core/grid/npy.h"
#include "firn/enums.h"
#include "firn/height_map_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/surface_mapper/path_mapper.h"

namespace firn {
namespace {

constexpr TimerId kLateRows{1};
constexpr double kWaitForRows_s = 2.0;
constexpr std::size_t kMaxPreviewCells = 14'800;  // of 4 bytes, within 60 kB with the message's head

}  // namespace

SurfaceMapper::SurfaceMapper(const Experiment& e, Mask mask)
    : grid_(e.grid), wait_s_(kWaitForRows_s * e.run.time_scale), mask_(std::move(mask)), map_(e.grid) {
  if (mask_.size() != grid_.size())
    throw std::invalid_argument("surface_mapper: the mask does not have the grid's size");
  if (e.control.smoothing > 0.0) smoother_.emplace(grid_);
  subscribe(channels::kHeightProfile, this);
  subscribe(channels::kScanDone, this);
}

bool SurfaceMapper::enter_scan(std::int64_t scan_id, Outbox& out) {
  if (scan_id < scan_id_ || (scan_id == scan_id_ && mapped_)) return false;
  if (scan_id == scan_id_) return true;
  if (!mapped_)
    out.warn("scan " + std::to_string(scan_id_) + " was left unfinished with " + std::to_string(rows_in_) +
             " rows");
  out.cancel(kLateRows);
  map_.clear();
  scan_id_ = scan_id;
  mapped_ = done_ = false;
  seen_.clear();
  rows_in_ = 0;
  last_sample_us_ = 0;
  return true;
}

void SurfaceMapper::on(const height_profile_t& m, Time, Outbox& out) {
  if (!enter_scan(m.scan_id, out)) return;
  if (seen_.size() < std::size_t(m.rows)) seen_.resize(std::size_t(m.rows));
  if (seen_[std::size_t(m.row)]) return;
  seen_[std::size_t(m.row)] = 1;
  ++rows_in_;
  last_sample_us_ = std::max(last_sample_us_, m.sample_utime_us);
  map_.add_row(m.y_mm, m.x0_mm, m.dx_mm, m.z_mm);
  if (done_ && rows_in_ >= scan_done_.rows_received) publish(out);
}

void SurfaceMapper::on(const scan_done_t& m, Time now, Outbox& out) {
  if (!enter_scan(m.scan_id, out) || done_) return;
  done_ = true;
  scan_done_ = m;
  if (rows_in_ >= m.rows_received) return publish(out);
  out.wake_at(kLateRows, now.after_s(wait_s_));
}

void SurfaceMapper::wake(TimerId timer, Time, Outbox& out) {
  if (timer != kLateRows || !done_ || mapped_) return;
  out.warn("scan " + std::to_string(scan_id_) + ": " + std::to_string(rows_in_) + " of " +
           std::to_string(scan_done_.rows_received) +
           " rows have come; the heights of the others are guesses");
  publish(out);
}

void SurfaceMapper::publish(Outbox& out) {
  out.cancel(kLateRows);
  mapped_ = true;
  surface::SurfaceEstimate e = map_.estimate(options_);
  if (smoother_ && e.measured_fraction > 0.0) smooth(e);

  height_map_t m{};
  m.layer = scan_done_.layer;
  m.attempt = scan_done_.attempt;
  m.map_id = ++maps_;
  m.sample_utime_us = last_sample_us_;
  m.noise_std_mm = e.noise_std_mm;
  m.measured_fraction = e.measured_fraction;
  m.rows_expected = std::max(1, scan_done_.rows_expected);
  m.rows_received = std::min(rows_in_, m.rows_expected);
  set_height(m, e.height);
  m.quality.assign(e.quality.cells.begin(), e.quality.cells.end());
  out.send(channels::kHeightMap, std::move(m));
  out.send(channels::kHeightPreview, preview_of(e.height, scan_done_.layer));
}

void SurfaceMapper::smooth(surface::SurfaceEstimate& e) {
  Grid<double> weights(grid_);
  for (std::size_t c = 0; c < weights.size(); ++c)
    weights.cells[c] =
        mask_.cells[c] && e.quality.cells[c] == std::uint8_t(CellQuality::kMeasured) ? 1.0 : 0.0;
  const surface::Smoothed s = smoother_->smooth(e.height, &weights, {});
  for (std::size_t c = 0; c < weights.size(); ++c)
    if (mask_.cells[c]) e.height.cells[c] = s.height.cells[c];
}

preview_t preview_of(const HeightMap& h, std::int32_t layer) {
  const GridSpec& g = h.spec;
  int block = 1;
  const auto blocks = [&](int n) { return (n + block - 1) / block; };
  while (std::size_t(blocks(g.nx)) * std::size_t(blocks(g.ny)) > kMaxPreviewCells) ++block;
  GridSpec small{blocks(g.nx),
                 blocks(g.ny),
                 g.pitch_x_mm * block,
                 g.pitch_y_mm * block,
                 g.origin_x_mm + 0.5 * (block - 1) * g.pitch_x_mm,
                 g.origin_y_mm + 0.5 * (block - 1) * g.pitch_y_mm};
  preview_t p{};
  p.layer = layer;
  p.grid = to_message(small);
  p.n = std::int32_t(small.size());
  for (int j = 0; j < small.ny; ++j)
    for (int i = 0; i < small.nx; ++i) {
      double sum = 0.0, n = 0.0;
      for (int y = j * block; y < std::min((j + 1) * block, g.ny); ++y)
        for (int x = i * block; x < std::min((i + 1) * block, g.nx); ++x) {
          sum += h.at(x, y);
          n += 1.0;
        }
      p.height_mm.push_back(float(sum / n));
    }
  return p;
}

std::unique_ptr<Node> make_surface_mapper(const std::string& config_toml, const Blobs& blobs) {
  const Experiment e = parse_recorded_experiment(config_toml, "experiment.toml");
  if (prints_paths(e)) {
    const std::vector<std::byte>& machine = blob(blobs, "machine").bytes;
    return std::make_unique<PathMapper>(
        e,
        parse_machine(std::string(reinterpret_cast<const char*>(machine.data()), machine.size()), "machine"),
        slice::decode_print_paths(blob(blobs, "paths").bytes));
  }
  return std::make_unique<SurfaceMapper>(e, mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"));
}

}  // namespace firn
