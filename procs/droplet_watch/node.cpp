#include "procs/droplet_watch/node.h"

#include <numbers>
#include <optional>

#include "core/grid/png.h"
#include "core/vision/sweep.h"
#include "firn/droplet_sweep_t.hpp"
#include "firn/enums.h"
#include "lcmtypes/camera_picture.h"

namespace firn {
namespace {

constexpr double kUmPerMm = 1e3, kMmPerSPerMPerS = 1e3, kUsPerS = 1e6, kPlPerMm3 = 1e6;
constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr std::size_t kMinForBackground = 5;

}  // namespace

DropletWatchNode::DropletWatchNode(const Experiment& e) : options_(e.watch) {
  subscribe(channels::kCameraFrame, this);
}

void DropletWatchNode::on(const camera_frame_t& m, Time, Outbox& out) {
  if (!pictures_.empty() && m.sweep_id != first_.sweep_id) measure(out);
  if (pictures_.empty()) {
    first_ = m;
    first_.png.clear();
  }
  try {
    pictures_.push_back({m.delay_us, frame_of(m)});
  } catch (const PngError& error) {
    out.warn("CAMERA_FRAME " + std::to_string(m.index) + " of sweep " + std::to_string(m.sweep_id) + " " +
             error.what());
  }
  if (m.index + 1 == m.frames) measure(out);
}

void DropletWatchNode::measure(Outbox& out) {
  const std::vector<Picture> pictures = std::move(pictures_);
  pictures_.clear();
  std::vector<const vision::Frame*> frames;
  for (const Picture& p : pictures) frames.push_back(&p.frame);
  const bool moves = !pictures.empty() && pictures.front().delay_us != pictures.back().delay_us;
  std::optional<vision::Background> background;
  if (frames.size() >= kMinForBackground) background = vision::find_background(frames, moves);
  std::vector<vision::TimedPicture> timed;
  std::vector<vision::DropletPicture> found;
  for (const Picture& p : pictures) {
    found.push_back(vision::find_droplets(p.frame, background ? &*background : nullptr));
    timed.push_back({p.delay_us, found.back()});
  }
  vision::Scale scale{options_.um_per_px, 0.0};
  if (options_.nozzle_um > 0.0 && options_.um_per_px == 0.0)
    scale = vision::scale_from_nozzle(found, options_.nozzle_um);
  const vision::SweepResult r = vision::measure_sweep(timed, scale);

  droplet_sweep_t m{};
  m.sweep_id = first_.sweep_id;
  m.layer = first_.layer;
  m.attempt = first_.attempt;
  m.frames = std::int32_t(pictures.size());
  m.with_droplet = r.with_droplet;
  m.used = r.used;
  m.um_per_px = scale.um_per_px;
  m.um_per_px_std = scale.std;
  m.middle_us = r.middle_us;
  const auto put = [&m](const vision::Estimate& e, double unit, SweepValue bit, double& value, double& std) {
    if (!e.known) return;
    m.known |= std::int32_t(bit);
    value = e.value / unit;
    std = e.std / unit;
  };
  using enum SweepValue;
  put(r.velocity_m_s, 1.0 / kMmPerSPerMPerS, kVelocity, m.velocity_mm_s, m.velocity_std_mm_s);
  put(r.angle_deg, kDegPerRad, kAngle, m.angle_rad, m.angle_std_rad);
  put(r.diameter_um, kUmPerMm, kDiameter, m.diameter_mm, m.diameter_std_mm);
  put(r.volume_pl, kPlPerMm3, kVolume, m.volume_mm3, m.volume_std_mm3);
  put(r.satellites, 1.0, kSatellites, m.satellites, m.satellites_std);
  put(r.break_off_us, kUsPerS, kBreakOff, m.break_off_s, m.break_off_std_s);
  put(r.jitter_us, kUsPerS, kJitter, m.jitter_s, m.jitter_std_s);
  out.send(channels::kDropletSweep, m);
}

std::unique_ptr<Node> make_droplet_watch(const std::string& config_toml, const Blobs&) {
  return std::make_unique<DropletWatchNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
