#include "procs/camera/node.h"

#include <algorithm>

#include "config/device_kinds.h"
#include "core/grid/png.h"
#include "drivers/camera/camera.h"
#include "drivers/camera/script_camera.h"
#include "firn/camera_frame_t.hpp"
#include "firn/camera_preview_t.hpp"

namespace firn {
namespace {

constexpr int kPreview_px = 200;

std::unique_ptr<drivers::CameraDriver> camera_driver(const Experiment& e) {
  const drivers::CameraOptions c{e.camera, host_latency_s(e.run.time_scale)};
  if (is_python_driver(e, "camera"))
    return std::make_unique<drivers::ScriptCamera>(script_options(e, "camera", c.host_latency_s), c);
  return std::make_unique<drivers::Camera>(c);
}

}  // namespace

CameraNode::CameraNode(const Experiment& e)
    : DriverNode(NodeId::kCamera, camera_driver(e)), preview_s_(e.camera.preview_s) {
  subscribe(channels::kCameraCommand, this);
}

void CameraNode::on(const camera_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  const bool pictures = CameraVerb(c.verb) == CameraVerb::kSweep;
  const drivers::Sweep wanted{c.frames, c.delay_us, c.step_us, c.exposure_us, c.gain_db};
  perform(c, false, now, out, [&](auto& camera, std::int64_t now_us, Effects& fx) {
    if (!pictures) return camera->set_up(wanted, now_us, fx);
    sweep_ = c;
    camera->sweep(wanted, now_us, fx);
  });
}

void CameraNode::on_measured(drivers::CameraShot& s, Time now, Outbox& out) {
  const drivers::Picture& p = s.picture;
  camera_frame_t m{};
  const std::vector<std::byte> png = write_grey_png(p.width, p.height, p.white, p.pixels);
  m.n = std::int32_t(png.size());
  m.png.resize(png.size());
  std::ranges::transform(png, m.png.begin(), [](std::byte b) { return std::uint8_t(b); });
  m.layer = sweep_.layer;
  m.attempt = sweep_.attempt;
  m.sweep_id = sweep_.sweep_id;
  m.index = s.index;
  m.frames = s.sweep.frames;
  m.sample_utime_us = now.us - p.age_us;
  m.width = p.width;
  m.height = p.height;
  m.white = p.white;
  m.delay_us = s.sweep.delay_of(s.index);
  m.exposure_us = s.sweep.exposure_us;
  m.gain_db = s.sweep.gain_db;
  out.send(channels::kCameraFrame, std::move(m));
  send_preview(p, now, out);
}

void CameraNode::send_preview(const drivers::Picture& p, Time now, Outbox& out) {
  if (now < preview_after_) return;
  preview_after_ = now.after_s(preview_s_);
  const int step = (std::max(p.width, p.height) + kPreview_px - 1) / kPreview_px;
  camera_preview_t m{};
  m.sweep_id = sweep_.sweep_id;
  m.width = p.width / step;
  m.height = p.height / step;
  m.n = m.width * m.height;
  m.grey.reserve(std::size_t(m.n));
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) {
      const std::uint32_t v = p.pixels[std::size_t(y) * std::size_t(step) * std::size_t(p.width) +
                                       std::size_t(x) * std::size_t(step)];
      m.grey.push_back(std::uint8_t(std::min(255u, v * 255u / std::uint32_t(p.white))));
    }
  out.send(channels::kCameraPreview, std::move(m));
}

std::unique_ptr<Node> make_camera(const std::string& config_toml, const Blobs&) {
  return std::make_unique<CameraNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
