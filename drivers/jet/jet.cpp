#include "drivers/jet/jet.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace firn::drivers {

using jetdrive::Command;

namespace {

constexpr std::int64_t kBootWait_us = 1'000'000;
constexpr int kAsks = 5;  // 2.5 s: an answer may be lost on the line, and a jet may hang for a while
constexpr std::int64_t kAsk_us = 250'000;

Request with_u8(Command command, int value, Repeat repeat = Repeat::kSetup) {
  const std::uint8_t data[1] = {std::uint8_t(value)};
  return jetdrive::frame(command, data, repeat);
}

Request with_u16(Command command, int value) {
  const std::uint8_t data[2] = {std::uint8_t(unsigned(value) >> 8), std::uint8_t(value)};
  return jetdrive::frame(command, data, Repeat::kSetup);
}

std::string name_of(const Request& request) {
  static constexpr std::pair<Command, const char*> kNames[] = {{Command::kReset, "RESET"},
                                                               {Command::kPoll, "POLL"},
                                                               {Command::kDrops, "DROPS"},
                                                               {Command::kContinuous, "CONTMODE"},
                                                               {Command::kPulse, "PULSE"},
                                                               {Command::kStrobeDivider, "STROBEDIV"},
                                                               {Command::kSource, "SOURCE"},
                                                               {Command::kSoftTrigger, "SOFTTRIGGER"},
                                                               {Command::kStrobeEnable, "STROBEENABLE"},
                                                               {Command::kFullFrequency, "FULLFREQ"},
                                                               {Command::kStrobeDelay, "STROBEDELAY"},
                                                               {Command::kGetVersion, "GETVERSION"}};
  if (request.format == jetdrive::kPrompt || request.format == jetdrive::kEcho)
    return "the start-up handshake";
  for (const auto& [command, text] : kNames)
    if (int(command) == request.argument) return text;
  return "command " + std::to_string(request.argument);
}

void check_range(const char* what, int value, int low, int high) {
  if (value < low || value > high)
    throw std::invalid_argument(std::string("jet: ") + what + " = " + std::to_string(value) +
                                " is outside [" + std::to_string(low) + ", " + std::to_string(high) + "]");
}

}  // namespace

Jet::Jet(JetOptions config)
    : JetDriver(dialect_, JetKind::kJetdrive, config), waveform_(jetdrive::waveform_of(config)) {
  dialect_.layout = config_.dialect;
  dialect_.allow_host_latency(config.host_latency_s);
  identity_ = "MicroFab JetDrive III";
  check_range("drops_per_trigger", config.drops_per_trigger, 1, 65535);
  check_options("jet", kJetDialect, config_.dialect, "dialect.");
  const JetDialect& d = config_.dialect;
  check_range("dialect.command_at", d.command_at, 1, std::min(d.size, d.version_size) - 2);
  check_range("dialect.status_at", d.status_at, 1, std::min(d.size, d.version_size) - 2);
  if (const Violation broken = jetdrive::waveform_refusal(waveform_, config_.dialect); !broken.empty())
    throw std::invalid_argument("jet: " + broken.text);
}

void Jet::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  const bool may_keep = on(config_.keep_firmware) && !reset_wanted_;
  if (asks_left_ == 0 || !(may_keep || (may_fire_ && tells_source()))) return start_firmware();
  --asks_left_;
  phase_ = Phase::kAsking;
  Request poll = jetdrive::frame(Command::kPoll, {}, Repeat::kNever);  // without an answer: connected anew
  if (may_keep) poll.reply_us = kAsk_us;
  link_.push(poll);
}

void Jet::start_firmware() {
  phase_ = Phase::kHandshake;
  asks_left_ = 0;
  Request stop_program;  // the boot monitor answers with a prompt
  stop_program.append("Q");
  stop_program.format = jetdrive::kPrompt;
  stop_program.repeat = Repeat::kNever;
  stop_program.reply_us = 3'000'000;
  link_.push(stop_program);
  for (const char c : std::string_view("X2000")) {  // starts the firmware; one byte at a time, each echoed
    Request r;
    r.append(std::string_view(&c, 1));
    r.format = jetdrive::kEcho;
    r.repeat = Repeat::kNever;
    link_.push(r);
  }
}

// One that was without power is in its boot monitor, which knows no POLL. A jet that still has its external
// source has been armed all the time.
void Jet::firmware_runs(bool external, std::int64_t now_us) {
  if (may_fire_ && tells_source()) {
    settled_ = external;
    if (settled_) {
      not_armed_.clear();
      disarmed_before_its_time(now_us);  // by the setup
    }
  }
  if (!on(config_.keep_firmware) || reset_wanted_) return start_firmware();
  phase_ = Phase::kSetup;
  push_setup(false);
}

void Jet::push_setup(bool reset_it) {
  if (reset_it) {
    Request reset = jetdrive::frame(Command::kReset, {}, Repeat::kSetup);
    reset.reply_us = 4'000'000;
    link_.push(reset);
  } else {
    link_.push(with_u8(Command::kSource, 0));  // before the waveform, which is never changed while jetting
    link_.push(with_u8(Command::kContinuous, 0));
  }
  link_.push(jetdrive::frame(Command::kGetVersion, {}, Repeat::kRead));
  send_waveform();
  if (reset_it) link_.push(with_u8(Command::kContinuous, 0));
  link_.push(with_u16(Command::kDrops, config_.drops_per_trigger));
  link_.push(with_u16(Command::kFullFrequency, config_.max_rate_hz));
  link_.push(with_u8(Command::kStrobeDivider, config_.dialect.strobe_divider));
  link_.push(with_u8(Command::kStrobeEnable, config_.strobe));
  const std::uint8_t delay[3] = {0x01, std::uint8_t(unsigned(config_.dialect.strobe_delay_us) >> 8),
                                 std::uint8_t(config_.dialect.strobe_delay_us)};
  link_.push(jetdrive::frame(Command::kStrobeDelay, delay, Repeat::kSetup));
  link_.push(with_u8(Command::kSource, 0));
}

void Jet::poll() { link_.push(jetdrive::frame(Command::kPoll, {}, Repeat::kRead)); }

// Called while the jet is off: a waveform is never changed while jetting (I11).
void Jet::take_size(bool small) {
  if (small == small_ && waveform_held_) return;
  small_ = small;
  send_waveform();
}

void Jet::start_arming(bool small) {
  phase_ = Phase::kArming;
  take_size(small);
  link_.push(with_u16(Command::kDrops, config_.drops_per_trigger));
  link_.push(with_u8(Command::kSource, 1, Repeat::kNever));
  settled_ = source_external_ = false;
  asks_left_ = on(config_.keep_firmware) ? kAsks : 1;
  if (tells_source()) poll();
}

void Jet::jet(std::int64_t now_us, Effects& fx) {
  if (accepts(ready(), fx)) {
    op_ = Op::kJet;
    phase_ = Phase::kStartingJet;
    expected_ = 0;
    not_armed_.clear();
    jetting_ = true;
    jet_until_us_ = now_us + std::int64_t(config_.dialect.most_continuous_s * 1e6);
    take_size(false);
    link_.push(with_u8(Command::kContinuous, 1, Repeat::kNever));
    link_.push(jetdrive::frame(Command::kSoftTrigger, {}, Repeat::kNever));
    set_state(DeviceState::kActive, "jetting", fx);
  }
  pump(now_us, fx);
}

void Jet::end_jetting(std::int64_t now_us, Effects& fx) {
  if (jetting_) link_.urgent(with_u8(Command::kContinuous, 0), now_us, fx);
}

void Jet::send_waveform() {
  waveform_held_ = false;
  link_.push(jetdrive::pulse(small_ ? jetdrive::small_waveform_of(config_) : waveform_));
}

void Jet::set_waveform(const jetdrive::Waveform& waveform, std::int64_t now_us, Effects& fx) {
  begin_waveform(waveform, fx);
  pump(now_us, fx);
}

void Jet::begin_waveform(const jetdrive::Waveform& waveform, Effects& fx) {
  const Violation broken = jetdrive::waveform_refusal(waveform, config_.dialect);
  if (!broken.empty()) {
    refuse_service(kJetLimit, broken.text, fx, broken.figure);
  } else if (busy() || phase_ != Phase::kReady) {
    refuse_service(kJetLimit, std::string("the waveform is never changed while the jet is ") + standing(),
                   fx);
  } else {
    op_ = Op::kWaveform;
    phase_ = Phase::kWaveform;
    small_ = false;
    waveform_ = waveform;
    send_waveform();
    set_state(DeviceState::kStaged, "new waveform", fx);
  }
}

void Jet::start_disarming(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kArmed && tells_source()) {
    poll();
    link_.push(with_u8(Command::kSource, 0));
  } else {
    end_jetting(now_us, fx);
    link_.urgent(with_u8(Command::kSource, 0), now_us, fx);
  }
  phase_ = Phase::kDisarming;
}

// The source as POLL tells it, while it should be external.
void Jet::take_source(bool external, std::int64_t now_us, Effects& fx) {
  if (external) return;
  const bool arming = phase_ == Phase::kArming;
  const std::string why = arming ? "it acknowledges SOURCE 1 and is not armed" : "it is not armed any more";
  not_armed_ = why;
  fault(phase_ == Phase::kDisarming ? Severity::kWarning : Severity::kStop, kInstrument, "jet: " + why, fx);
  if (!arming) return;
  ending_ = why;
  ending_code_ = kInstrument;
  end_quietly(now_us, fx);
}

void Jet::end_quietly(std::int64_t now_us, Effects& fx) {
  link_.clear_queue();
  phase_ = Phase::kStopping;
  end_jetting(now_us, fx);
  link_.urgent(with_u8(Command::kSource, 0), now_us, fx);
}

void Jet::cease(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kHandshake || phase_ == Phase::kBooting)
    return;                                                           // firmware not running: it cannot fire
  if (phase_ == Phase::kAsking) return;                               // its answer leads to a setup
  if (phase_ == Phase::kSetup || phase_ == Phase::kStopping) return;  // ends with the source internal
  link_.clear_queue();
  phase_ = Phase::kStopping;
  if (busy()) ending_ = "safe stop";
  end_jetting(now_us, fx);
  link_.urgent(with_u8(Command::kSource, 0), now_us, fx);
  if (!link_.suspect()) return;
  if (jetting_) link_.push(with_u8(Command::kContinuous, 0));
  link_.push(with_u8(Command::kSource, 0));
}

void Jet::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) {
  if (request.format == jetdrive::kPrompt) return;
  if (request.format == jetdrive::kEcho) {
    if (!link_.idle()) return;
    phase_ = Phase::kBooting;
    boot_until_us_ = now_us + kBootWait_us;
    return;
  }
  const jetdrive::Reply r = dialect_.parse(frame);
  if (phase_ == Phase::kAsking)
    return r.acknowledged ? firmware_runs(r.status & config_.dialect.source_bit, now_us) : start_firmware();
  if (!r.acknowledged) {
    const std::string why =
        "the jet refuses " + name_of(request) + " (status " + std::to_string(r.status) + ")";
    fault(phase_ == Phase::kDisarming || phase_ == Phase::kStopping ? Severity::kStop : Severity::kWarning,
          kCommandRejected, "jet: " + why, fx);
    if (phase_ == Phase::kSetup) asks_left_ = 0;
    if (phase_ == Phase::kSetup || phase_ == Phase::kDisarming || phase_ == Phase::kStopping)
      return reconnect(now_us, fx, why);
    if (busy()) {
      ending_ = why;
      ending_code_ = kCommandRejected;
      end_quietly(now_us, fx);
    }
    return;
  }
  if (request.argument == int(Command::kPulse)) waveform_held_ = true;
  if (request.argument == int(Command::kSource)) source_external_ = phase_ == Phase::kArming;
  const bool polled = request.argument == int(Command::kPoll) && tells_source() && source_external_;
  if (polled && (phase_ == Phase::kArming || phase_ == Phase::kArmed || phase_ == Phase::kDisarming))
    return take_source(r.status & config_.dialect.source_bit, now_us, fx);
  if (request.format != jetdrive::kVersion) return;
  version_ = r.version;
  identity_ = "MicroFab JetDrive III firmware " + std::to_string(r.version);
}

void Jet::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  const std::string why = "no good reply to " + name_of(request) + not_understood();
  fault(Severity::kWarning, kLinkLost, "jet: " + why, fx);
  if (phase_ == Phase::kStopping && request.repeat == Repeat::kNever) return;
  if (phase_ == Phase::kAsking && on(config_.keep_firmware)) identified();  // the next try is no later
  if (phase_ != Phase::kArming && phase_ != Phase::kStartingJet) return reconnect(now_us, fx, why);
  ending_ = why;  // it may be armed: make sure that it is not
  ending_code_ = kLinkLost;
  end_quietly(now_us, fx);
  if (jetting_) link_.push(with_u8(Command::kContinuous, 0));
  link_.push(with_u8(Command::kSource, 0));
}

void Jet::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  const bool starting = phase_ == Phase::kAsking || phase_ == Phase::kHandshake ||
                        phase_ == Phase::kBooting || phase_ == Phase::kSetup;
  if (phase_ == Phase::kArmed || phase_ == Phase::kJetting ||
      (busy() && !starting))  // else it was told when that link was lost
    fault(Severity::kStop, kLinkLost, "jet: link lost while in use", fx);
  if (busy() && ending_.empty()) {
    ending_ = "the link was lost";
    ending_code_ = kLinkLost;
  }
  if (may_fire_ && !settled_) not_armed_ = "the link was lost while it was armed";
  phase_ = Phase::kDown;
}

bool Jet::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kBooting:
      if (now_us < boot_until_us_) return false;
      phase_ = Phase::kSetup;
      push_setup(true);
      return true;
    case Phase::kSetup:
      identified();
      reset_wanted_ = false;
      if (on(config_.keep_firmware)) asks_left_ = kAsks;
      [[fallthrough]];
    case Phase::kStopping:
      // A command that a stop or a lost link has cut short ends here, with the source confirmed internal.
      may_fire_ = jetting_ = false;
      if (op_ == Op::kDisarm)
        finish_pass(ending_, fx);
      else if (op_ == Op::kArm)
        finish(Outcome::kNone, ending_code_, ending_, fx);
      else
        finish(Outcome::kFailed, ending_code_, ending_, fx);
      ending_.clear();
      ending_code_ = kNoCode;
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "trigger source internal", fx);
      return false;
    case Phase::kArming:
      phase_ = Phase::kArmed;
      armed("trigger source external", fx);
      return false;
    case Phase::kDisarming:
      phase_ = Phase::kReady;
      may_fire_ = jetting_ = false;
      set_state(DeviceState::kSafe, "trigger source internal", fx);
      finish_pass(ending_, fx);
      return false;
    case Phase::kStartingJet:
      phase_ = Phase::kJetting;
      finish(Outcome::kReady, kNoCode, {}, fx);
      return false;
    case Phase::kJetting:
      if (now_us < jet_until_us_) return false;
      fault(Severity::kWarning, kJetLimit, "jet: it has jetted for as long as it may", fx);
      end_quietly(now_us, fx);
      return true;
    case Phase::kWaveform:
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "waveform set", fx);
      finish(Outcome::kDone, kNoCode, {}, fx);
      return false;
    case Phase::kReady:
    case Phase::kArmed:
      if (now_us < poll_at_us()) return false;
      link_.push(jetdrive::frame(Command::kPoll, {}, Repeat::kRead));
      return true;
    default:
      return false;
  }
}

std::int64_t Jet::device_wake_us() const {
  if (!link_.idle()) return 0;
  if (phase_ == Phase::kBooting) return boot_until_us_;
  if (phase_ == Phase::kJetting) return jet_until_us_;
  return JetDriver::device_wake_us();
}

}  // namespace firn::drivers
