// The droplet loop's watch of its jet: to the camera, jetting, pictures, and the sweep's result.
#include <algorithm>
#include <utility>

#include "firn/camera_command_t.hpp"
#include "firn/jet_command_t.hpp"
#include "firn/stage_command_t.hpp"
#include "procs/scheduler/droplet_loop.h"
#include "procs/scheduler/jet_check.h"

namespace firn {
namespace {

constexpr double kJetPicture_s = 1.0;  // longest time of one picture

}  // namespace

bool DropletLoop::watch_due() const {
  const Experiment& e = experiment();
  const bool wanted = firn::on(e.watch.gate) || firn::on(e.watch.placement) || volume_first();
  if (!firn::on(e.camera.use) || !wanted) return false;
  return watched_layer_ == 0 ||
         (e.watch.every_layers > 0 && job_.layer() - watched_layer_ >= e.watch.every_layers);
}

// The droplet estimator's prior: before the map from which layer 1 is planned.
bool DropletLoop::volume_first() const { return experiment().estimator.droplets == "camera"; }

bool DropletLoop::enter_watch(Phase next, Time now, Outbox& out) {
  switch (next) {
    case Phase::kToCamera:
      sweep_.reset();
      send_move(experiment().watch.x_mm, experiment().watch.y_mm, now, out);
      return true;
    case Phase::kPurging:
    case Phase::kJetting:
      send_jetting(JetVerb::kJet, now, out);
      return true;
    case Phase::kPictures:
      send_pictures(now, out);
      return true;
    case Phase::kEndPurge:
    case Phase::kEndJetting:
      send_jetting(JetVerb::kDisarm, now, out);
      return true;
    case Phase::kAwaitSweep:
      out.wake_at(kDeadline, now.after_s(kSlackWall_s * experiment().run.time_scale));
      act_on_sweep(now, out);
      return true;
    default:
      return false;
  }
}

bool DropletLoop::watch_answered(Time now, Outbox& out) {
  switch (phase_) {
    case Phase::kToCamera:
      proceed(Phase::kJetting, now, out);
      return true;
    case Phase::kPurging:
      out.wake_at(kPurge, now.after_s(experiment().watch.purge_s));
      return true;
    case Phase::kEndPurge:
      proceed(Phase::kJetting, now, out);
      return true;
    case Phase::kJetting:
      proceed(Phase::kPictures, now, out);
      return true;
    case Phase::kPictures:
      proceed(Phase::kEndJetting, now, out);
      return true;
    case Phase::kEndJetting:
      proceed(Phase::kAwaitSweep, now, out);
      return true;
    default:
      return false;
  }
}

void DropletLoop::wake(TimerId timer, Time now, Outbox& out) {
  if (timer != kPurge) return Scheduler::wake(timer, now, out);
  if (phase_ == Phase::kPurging) proceed(Phase::kEndPurge, now, out);
}

void DropletLoop::on(const droplet_sweep_t& m, Time now, Outbox& out) {
  if (m.sweep_id != sweep_id_) return;
  sweep_ = m;
  if (phase_ == Phase::kAwaitSweep) act_on_sweep(now, out);
}

// The gate alone stops the print: without it, a sweep that shows no droplet leaves the pulses where they are.
void DropletLoop::act_on_sweep(Time now, Outbox& out) {
  if (!sweep_) return;
  const droplet_sweep_t m = *std::exchange(sweep_, std::nullopt);
  out.cancel(kDeadline);
  const Experiment& e = experiment();
  const Violation what = jet_out_of_band(m, e.watch);
  const std::string text =
      "the jet before layer " + std::to_string(std::max(1, job_.layer())) + ": " + what.text;
  if (!what.empty() && firn::on(e.watch.gate)) {
    if (!std::exchange(purged_, true)) {
      out.report(Severity::kWarning, text + "; purging once", 11, what.figure);
      return proceed(Phase::kPurging, now, out);
    }
    purged_ = false;
    phase_ = Phase::kToCamera;  // a resume looks again
    return fail(11, text, now, out, what.figure);
  }
  if (!what.empty()) out.report(Severity::kWarning, text, 11, what.figure);
  purged_ = false;
  watched_layer_ = std::max(1, job_.layer());
  if (firn::on(e.watch.placement)) lead_mm_ = lead_of(m, e.process.pass_speed_mm_s, e.process.nozzle_gap_mm);
  proceed(job_.layer() > 0 ? Phase::kArmJet : Phase::kArmProfiler, now, out);
}

// The camera sees the jet of ink A.
void DropletLoop::send_jetting(JetVerb verb, Time now, Outbox& out) {
  jet_command_t c{};
  c.verb = std::int8_t(verb);
  stamp(c, NodeId::kJet, 10.0, now, out);
  out.send(channels::kJetCommand, c);
}

void DropletLoop::send_pictures(Time now, Outbox& out) {
  const droplet::WatchOptions& o = experiment().watch;
  camera_command_t c{};
  c.verb = std::int8_t(CameraVerb::kSweep);
  c.sweep_id = ++sweep_id_;
  c.frames = o.frames;
  c.delay_us = o.first_us;
  c.step_us = o.step_us;
  c.gain_db = experiment().camera.gain_db;
  stamp(c, NodeId::kCamera, o.frames * (kJetPicture_s + experiment().camera.exposure_us * 1e-6), now, out);
  out.send(channels::kCameraCommand, c);
}

}  // namespace firn
