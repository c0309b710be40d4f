#include "drivers/jet/microdrop.h"

#include <charconv>
#include <cmath>

namespace firn::drivers {
namespace {

constexpr std::size_t kLongestLine = 100;

std::string shown(const Request& r) { return "'" + std::string(r.text().substr(0, r.size - 1u)) + "'"; }

}  // namespace

namespace microdrop {

std::int32_t number_of(std::span<const std::byte> line) {
  const auto* text = reinterpret_cast<const char*>(line.data());
  std::int32_t n = -1;
  const auto r = std::from_chars(text + 1, text + std::max<std::size_t>(line.size(), 1), n);
  return r.ec == std::errc() && *r.ptr == '\r' ? n : -1;
}

Request command(const std::string& text, Repeat repeat) {
  Request r;
  r.append(text + "\r");
  r.repeat = repeat;
  r.argument = kUnchecked;
  return r;
}

Request command(const char* text, double v) { return command(text + std::to_string(std::lround(v)) + ")"); }

Request question(const char* text, double expected) {
  Request r = command(text, Repeat::kRead);
  r.format = kNumber;
  r.argument = std::int32_t(std::lround(expected));
  return r;
}

}  // namespace microdrop

using namespace microdrop;

Frame MicrodropDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const auto end = std::find(buffer.begin(), buffer.end(), std::byte('\r'));
  const auto size = std::size_t(end - buffer.begin()) + 1;
  if (end == buffer.end()) return size > kLongestLine ? Frame{Frame::Kind::kCorrupt, buffer.size()} : Frame{};
  if (!awaited) return {Frame::Kind::kUnsolicited, size};
  const bool good = awaited->format == kAny || number_of(buffer.first(size)) >= 0;
  return {good ? Frame::Kind::kReply : Frame::Kind::kCorrupt, size};
}

Request MicrodropDialect::probe() const { return question("GetFrequency(1)"); }

Microdrop::Microdrop(JetOptions config) : Driver(dialect_), config_(std::move(config)) {
  check_options("jet", kJetConfig, config_);
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "Microdrop MD-E";
}

void Microdrop::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kSetup;
  link_.push(command("SetActive(1,0)"));
  if (!config_.trigger_off.empty()) link_.push(command(config_.trigger_off));
  link_.push(command("SetPulseVoltage(1,1,", config_.dwell_v));
  link_.push(command("SetPulseLength(1,1,", config_.dwell_us));
  link_.push(command("RefreshPulse(1)"));
  link_.push(command("SetFrequency(1,", config_.max_rate_hz));
  link_.push(command("SetDrops(1,1)"));
  read_back();
}

// No public source tells how a refusal reads: that a setting is held is the evidence that it was taken, and
// that the unit has had its power.
void Microdrop::read_back() {
  link_.push(question("GetPulseVoltage(1,1)", config_.dwell_v));
  link_.push(question("GetPulseLength(1,1)", config_.dwell_us));
  link_.push(question("GetFrequency(1)", config_.max_rate_hz));
  link_.push(question("GetDrops(1)", 1));
}

void Microdrop::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  if (outcome != Outcome::kRefused) op_ = Op::kNone;
  fx.events.emplace_back(
      Result{outcome, -1, expected_, 0, outcome == Outcome::kUnknown ? expected_ : 0, code, std::move(text)});
}

void Microdrop::arm(std::int64_t expected, std::int64_t now_us, Effects& fx) {
  if (busy() || phase_ != Phase::kReady) {
    finish(Outcome::kRefused, kNoCode, "the jet is busy or " + std::string(name(state())), fx);
  } else if (config_.trigger_on.empty()) {
    finish(Outcome::kRefused, kInstrument,
           "the Microdrop's known commands name no external trigger, so that the stage cannot fire it: "
           "jet.trigger_on and jet.trigger_off take the texts of the unit's manual [P]",
           fx);
  } else {
    op_ = Op::kArm;
    phase_ = Phase::kArming;
    expected_ = expected;
    doubt_.clear();
    may_fire_ = true;
    link_.push(command("SetActive(1,1)", Repeat::kNever));
    link_.push(command(config_.trigger_on, Repeat::kNever));
    set_state(DeviceState::kStaged, "arming", fx);
  }
  pump(now_us, fx);
}

void Microdrop::disarm(std::int64_t now_us, Effects& fx) {
  if (busy() || (phase_ != Phase::kReady && phase_ != Phase::kArmed)) {
    finish(Outcome::kRefused, kNoCode, "the jet is busy or " + std::string(name(state())), fx);
    return pump(now_us, fx);
  }
  op_ = Op::kDisarm;
  safe_stop(now_us, fx);
}

void Microdrop::stop(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kSetup || phase_ == Phase::kStopping) return;
  link_.clear_queue();
  phase_ = Phase::kStopping;
  link_.urgent(command("SetActive(1,0)"), now_us, fx);
  if (link_.suspect()) link_.push(command("SetActive(1,0)"));  // the first answer is drained
  if (!config_.trigger_off.empty()) link_.push(command(config_.trigger_off));
  read_back();
}

void Microdrop::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                      Effects& fx) {
  if (request.argument == kUnchecked || number_of(frame) == request.argument) return;
  const std::string why = shown(request) + " is " + std::to_string(number_of(frame)) + " instead of " +
                          std::to_string(request.argument);
  if (may_fire_) doubt_ = why;
  give_up(kInstrument, why, now_us, fx);
}

void Microdrop::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  give_up(kLinkLost, "no good reply to " + shown(request), now_us, fx);
}

void Microdrop::give_up(std::int32_t code, const std::string& why, std::int64_t now_us, Effects& fx) {
  fault(Severity::kWarning, code, "jet: " + why, fx);
  reconnect(now_us, fx, why);
}

void Microdrop::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (may_fire_ && phase_ != Phase::kSetup)
    fault(Severity::kStop, kLinkLost, "jet: link lost while in use", fx);
  if (may_fire_ && doubt_.empty()) doubt_ = "the link was lost while it was armed";
  phase_ = Phase::kDown;
}

bool Microdrop::idle(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kArming) {
    phase_ = Phase::kArmed;
    set_state(DeviceState::kArmed, "external trigger", fx);
    finish(Outcome::kReady, kNoCode, {}, fx);
  } else if (phase_ == Phase::kSetup || phase_ == Phase::kStopping) {
    identified();
    phase_ = Phase::kReady;
    may_fire_ = false;
    set_state(DeviceState::kSafe, "inactive", fx);
    const bool doubt = op_ == Op::kDisarm && !doubt_.empty();
    if (op_ == Op::kDisarm)
      finish(doubt ? Outcome::kUnknown : Outcome::kDone, doubt ? kInstrument : kNoCode, doubt_, fx);
    if (op_ == Op::kArm) finish(Outcome::kNone, kLinkLost, doubt_, fx);
  } else if ((phase_ == Phase::kReady || phase_ == Phase::kArmed) && now_us >= device_wake_us()) {
    link_.push(question("GetFrequency(1)", config_.max_rate_hz));
    return true;
  }
  return false;
}

std::int64_t Microdrop::device_wake_us() const {
  const bool waits = link_.idle() && (phase_ == Phase::kReady || phase_ == Phase::kArmed);
  return waits ? link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6) : 0;
}

}  // namespace firn::drivers
