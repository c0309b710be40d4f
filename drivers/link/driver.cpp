#include "drivers/link/driver.h"

#include <algorithm>
#include <stdexcept>

namespace firn::drivers {

void Driver::opened(std::int64_t now_us, Effects& fx) {
  if (link_.is_open()) went_down(now_us, fx, "opened again");
  reopen_at_us_ = 0;
  link_.opened(now_us);
  set_state(DeviceState::kConnecting, "port open", fx);
  pump(now_us, fx);
}

void Driver::closed(std::int64_t now_us, Effects& fx) {
  went_down(now_us, fx, "port closed");
  pump(now_us, fx);
}

void Driver::went_down(std::int64_t now_us, Effects& fx, std::string_view why) {
  link_.closed();
  answered_ = false;
  if (service_)
    end_service(service_->acts() ? Outcome::kUnknown : Outcome::kFailed, kLinkLost, std::string(why), fx);
  ending_tell_ = nullptr;
  lost(now_us, fx);
  if (lost_why_.empty() && state_ >= DeviceState::kSafe) lost_why_ = why;
  set_state(DeviceState::kDisconnected, why, fx);
  if (reopen_at_us_ == 0) reopen_at_us_ = now_us + backoff_us_;
}

std::string Driver::standing() const {
  const std::string now = drivers::standing(state_);
  if (state_ >= DeviceState::kSafe || lost_why_.empty()) return now;
  const bool away = state_ == DeviceState::kDisconnected;
  return now + (away ? " (" : ", since its connection was lost (") + lost_why_ + ")";
}

void Driver::reconnect(std::int64_t now_us, Effects& fx, std::string_view why) { went_down(now_us, fx, why); }

std::string Driver::not_understood() const {
  const std::string& line = link_.not_understood();
  return line.empty() ? line : "; not understood: " + line;
}

void Driver::received(std::span<const std::byte> bytes, std::int64_t now_us, Effects& fx) {
  link_.received(bytes, now_us);
  pump(now_us, fx);
}

void Driver::line_opened(std::int64_t now_us, Effects& fx) {
  line_is(true, now_us, fx);
  pump(now_us, fx);
}

void Driver::line_closed(std::int64_t now_us, Effects& fx) {
  line_is(false, now_us, fx);
  pump(now_us, fx);
}

void Driver::line_received(std::span<const std::byte> bytes, std::int64_t now_us, Effects& fx) {
  line_said(bytes, now_us, fx);
  pump(now_us, fx);
}

void Driver::woke(std::int64_t now_us, Effects& fx) { pump(now_us, fx); }

void Driver::safe_stop(std::int64_t now_us, Effects& fx) {
  if (service_) cut_service(now_us, fx);
  stop(now_us, fx);
  pump(now_us, fx);
}

void Driver::pump(std::int64_t now_us, Effects& fx) {
  if (!link_.is_open() && reopen_at_us_ != 0 && now_us >= reopen_at_us_) {
    backoff_us_ = std::min(2 * backoff_us_, kLongestBackoff);
    reopen_at_us_ = now_us + backoff_us_;  // asked again if nothing comes of it
    fx.reopen = true;
  }
  tick(now_us, fx);
  for (int n = 0;; ++n) {
    if (n > 100'000) throw std::logic_error("a driver makes no progress");
    if (const auto e = link_.poll(now_us, fx)) {
      using Kind = LinkEvent::Kind;
      switch (e->kind) {
        case Kind::kReady:
          connected(now_us, fx);
          break;
        case Kind::kReply:
          answered_ = true;
          if (e->request.tag == kServiceTag) {
            service_reply(*e, now_us, fx);
            break;
          }
          reply(e->request, e->frame, now_us, fx);
          break;
        case Kind::kFailed:
          if (service_ && e->request.tag == kServiceTag)
            end_service(service_->acts() ? Outcome::kUnknown : Outcome::kFailed, kLinkLost, "no good reply",
                        fx);
          failed(e->request, now_us, fx);
          break;
        case Kind::kUnsolicited:
          unsolicited(e->frame, now_us, fx);
          break;
        case Kind::kSuspect:
          before_suspect_ = state_;
          set_state(DeviceState::kSuspect, "a reply was lost or damaged", fx);
          break;
        case Kind::kRecovered:
          if (state_ == DeviceState::kSuspect) set_state(before_suspect_, "link sound again", fx);
          break;
        case Kind::kLost:
          fx.reopen = false;  // with the pause of went_down
          went_down(now_us, fx, "no answer" + not_understood());
          break;
      }
      continue;
    }
    if (!link_.idle()) break;
    if (service_ && advance_service(now_us, fx)) continue;
    if (!idle(now_us, fx)) break;
  }
  fx.wake_us = 0;
  const std::int64_t held_us = service_ && service_step_ == ServiceStep::kHold ? service_until_us_ : 0;
  for (const std::int64_t t : {link_.is_open() ? link_.wake_us() : reopen_at_us_, device_wake_us(), held_us})
    if (t != 0 && (fx.wake_us == 0 || t < fx.wake_us)) fx.wake_us = t;
}

void Driver::set_state(DeviceState state, std::string_view text, Effects& fx) {
  if (state_ == DeviceState::kSuspect && state != DeviceState::kSuspect && link_.suspect()) {
    before_suspect_ = state;  // told when the link is sound again
    return;
  }
  if (state_ == state) return;
  state_ = state;
  if (state >= DeviceState::kSafe) lost_why_.clear();
  fx.events.emplace_back(StateChange{state, std::string(text)});
}

void Driver::fault(Severity severity, std::int32_t code, std::string text, Effects& fx, Figure figure) {
  fx.events.emplace_back(Fault{severity, code, std::move(text), std::move(figure)});
}

}  // namespace firn::drivers
