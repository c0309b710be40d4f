#include "drivers/camera/camera.h"

#include <cmath>
#include <cstdio>

namespace firn::drivers {
namespace {

std::string_view first_line(std::span<const std::byte> frame) {
  const std::string_view text = text_of(frame);
  return text.substr(0, text.find('\n'));
}

}  // namespace

Camera::Camera(CameraOptions config) : CameraDriver(dialect_), config_(config) {
  check_options("camera", kCameraConfig, config_);
  dialect_.allow_host_latency(config.host_latency_s);
}

void Camera::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kIdentifying;
  link_.push(picture_line::identify());
}

void Camera::begin(Op op, const Sweep& sweep, Effects& fx) {
  std::string why;
  if (busy())
    why = "the camera is busy with another command";
  else if (phase_ != Phase::kReady)
    why = std::string("the camera is ") + standing();
  const bool ready = why.empty();
  if (ready) why = refusal_of(sweep, op == Op::kSweep);
  if (!why.empty()) {
    fx.events.emplace_back(Result{Outcome::kRefused, -1, 0, 0, 0, ready ? kLimit : kNoCode, std::move(why)});
    return;
  }
  op_ = op;
  sweep_ = sweep;
  if (sweep_.exposure_us == 0.0) sweep_.exposure_us = config_.exposure_us;
  taken_ = 0;
  phase_ = Phase::kTaking;
  set_state(DeviceState::kActive, op == Op::kSweep ? "taking pictures" : "setting up", fx);
  ask(0);
}

void Camera::sweep(const Sweep& sweep, std::int64_t now_us, Effects& fx) {
  begin(Op::kSweep, sweep, fx);
  pump(now_us, fx);
}

void Camera::set_up(const Sweep& sweep, std::int64_t now_us, Effects& fx) {
  begin(Op::kSetUp, sweep, fx);
  pump(now_us, fx);
}

// A snap of one number is asked again after a lost reply: it is a new picture with the same settings.
void Camera::ask(std::int32_t index) {
  link_.push(picture_line::set(sweep_.exposure_us, sweep_.gain_db, sweep_.delay_of(index)));
  if (op_ != Op::kSweep) return;
  number_ = number_ == INT32_MAX ? 1 : number_ + 1;
  link_.push(picture_line::snap(
      number_, std::int64_t(sweep_.exposure_us + (config_.picture_s + config_.host_latency_s) * 1e6)));
}

void Camera::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  if (op_ == Op::kNone) return;
  const bool pictures = op_ == Op::kSweep;
  op_ = Op::kNone;
  ending_.clear();
  fx.events.emplace_back(
      Result{outcome, pictures ? taken_ : -1, pictures ? sweep_.frames : 0, 0, 0, code, std::move(text)});
}

void Camera::stop(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kIdentifying) return;
  link_.clear_queue();
  finish(Outcome::kFailed, kNoCode, "safe stop", fx);
  phase_ = Phase::kReady;
  set_state(DeviceState::kSafe, "stopped", fx);
}

void Camera::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (busy()) {
    fault(Severity::kWarning, kLinkLost, "camera: link lost while in use", fx);
    ending_ = "the link was lost";
  }
  phase_ = Phase::kDown;
}

void Camera::failed(const Request&, std::int64_t now_us, Effects& fx) {
  reconnect(now_us, fx, "no good reply" + not_understood());
}

void Camera::take(std::span<const std::byte> frame, Effects& fx) {
  auto picture = picture_line::parse_picture(frame);
  if (!picture || op_ != Op::kSweep) return;  // a stop came between
  fx.measured<Camera>(CameraShot{taken_, sweep_, std::move(*picture)});
  if (++taken_ < sweep_.frames) ask(taken_);
}

void Camera::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                   Effects& fx) {
  const std::string_view sent = request.text(), verb = sent.substr(0, sent.find_first_of(" \n"));
  const auto r = picture_line::parse(first_line(frame), verb);
  if (!r) return;
  if (!r->accepted) {
    const std::string why = "it refuses " + std::string(verb) + ": " + std::string(r->text);
    fault(Severity::kWarning, kCommandRejected, "camera: " + why, fx);
    if (phase_ == Phase::kIdentifying) return reconnect(now_us, fx, why);
    link_.clear_queue();
    finish(Outcome::kFailed, kCommandRejected, why, fx);
    phase_ = Phase::kReady;
    return set_state(DeviceState::kSafe, why, fx);
  }
  if (verb == "ID") identity_ = std::string(r->text);
  if (verb == "SNAP") take(frame, fx);
}

bool Camera::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kIdentifying:
      identified();
      phase_ = Phase::kReady;
      if (busy()) finish(Outcome::kFailed, kLinkLost, ending_, fx);
      set_state(DeviceState::kSafe, "identified", fx);
      return false;
    case Phase::kTaking:
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "done", fx);
      finish(Outcome::kDone, kNoCode, {}, fx);
      return false;
    case Phase::kReady:
      if (now_us - link_.last_sent_us() < std::int64_t(config_.poll_idle_s * 1e6)) return false;
      link_.push(picture_line::identify());
      return true;
    default:
      return false;
  }
}

std::int64_t Camera::device_wake_us() const {
  if (!link_.idle() || phase_ != Phase::kReady) return 0;
  return link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6);
}

void Camera::service(std::string_view verb, std::span<const double> v, std::int64_t now_us, Effects& fx) {
  if (verb != "setup" || v.size() != 3) return Driver::service(verb, v, now_us, fx);
  begin(Op::kSetUp, Sweep{1, v[2], 0.0, v[0], v[1]}, fx);
}

}  // namespace firn::drivers
