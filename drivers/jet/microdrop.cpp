#include "drivers/jet/microdrop.h"

#include <cmath>

#include "core/options/number.h"

namespace firn::drivers {
namespace {

constexpr std::int32_t kUnchecked = -1;
enum MicrodropFormat : std::uint8_t { kAnything, kNumber };

std::string shown(const Request& r) { return "'" + std::string(r.text().substr(0, r.size - 1u)) + "'"; }

/// The number of an answer, which may have a character before it and zeros behind a point [S]; -1 = none.
std::int32_t number_of(std::string_view line) {
  line = line.substr(0, line.find('\r'));
  if (line.find_first_of("+-0123456789") != 0) line = line.substr(std::min<std::size_t>(line.size(), 1));
  const std::string_view whole = line.substr(0, line.find('.')), rest = line.substr(whole.size());
  return rest.find_first_not_of('0', 1) == rest.npos ? whole_number<std::int32_t>(whole).value_or(-1) : -1;
}

/// The number of an answer, or all of it: no public source tells how a version reads.
std::string told_by(std::string_view line) {
  const std::int32_t n = number_of(line);
  return n >= 0 ? std::to_string(n) : std::string(line.substr(0, line.find('\r')));
}

Request command(const std::string& text, Repeat repeat = Repeat::kSetup) {
  Request r;
  r.append(text + "\r");
  r.repeat = repeat;
  r.argument = kUnchecked;
  return r;
}

/// "SetFrequency(1," and a value, rounded.
Request command(const char* text, double v) { return command(text + std::to_string(std::lround(v)) + ")"); }

Request question(const char* text, double expected = kUnchecked) {
  Request r = command(text, Repeat::kRead);
  r.format = kNumber;
  r.argument = std::int32_t(std::lround(expected));
  return r;
}

}  // namespace

constinit const JetTraits kMicrodropTraits{
    .instrument = "a Microdrop jet",
    .make = &new_jet<Microdrop>,
    .questions = [] { return std::vector{MicrodropDialect().probe()}; },
    .answers = [](std::string_view heard) { return answers_probe(MicrodropDialect(), heard); },
    .trigger_by_words = true,
    .second_pulse = false,
    .min_v = 1.0,
    .step_us = 1.0,
    .max_divider = 1,
    .most_drops = 65535.0,
};

bool MicrodropDialect::answers(std::string_view body, const Request& asked) const {
  return asked.format == kAnything || number_of(body) >= 0;
}

Request MicrodropDialect::probe() const { return question("GetFrequency(1)"); }

Microdrop::Microdrop(JetOptions config) : JetDriver(dialect_, JetKind::kMicrodrop, std::move(config)) {
  dialect_.allow_host_latency(config_.host_latency_s);
}

std::vector<Request> Microdrop::pulse_set() const {
  return {command("SetPulseVoltage(1,1,", config_.dwell_v), command("SetPulseLength(1,1,", config_.dwell_us),
          command("RefreshPulse(1)")};
}

// No public source tells how a refusal reads: that a setting is held is the evidence that it was taken, and
// that the unit has had its power.
std::vector<Request> Microdrop::held() const {
  return {question("GetPulseVoltage(1,1)", config_.dwell_v),
          question("GetPulseLength(1,1)", config_.dwell_us), question("GetFrequency(1)", config_.max_rate_hz),
          question("GetDrops(1)", 1)};
}

void Microdrop::connected(std::int64_t, Effects& fx) {
  identity_ = "Microdrop MD-E";
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kSetup;
  link_.push(command("SetActive(1,0)"));
  if (!config_.trigger_off.empty()) link_.push(command(config_.trigger_off));
  for (const Request& r : pulse_set()) link_.push(r);
  link_.push(command("SetFrequency(1,", config_.max_rate_hz));
  link_.push(command("SetDrops(1,1)"));
  for (const Request& r : held()) link_.push(r);
  link_.push(command("GetConfig(1,3)", Repeat::kRead));
  link_.push(command("GetConfig(1,6)", Repeat::kRead));
}

void Microdrop::start_arming(bool) {
  phase_ = Phase::kArming;
  link_.push(command("SetActive(1,1)", Repeat::kNever));
  link_.push(command(config_.trigger_on, Repeat::kNever));
}

void Microdrop::cease(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kDown || phase_ == Phase::kSetup || phase_ == Phase::kStopping) return;
  link_.clear_queue();
  phase_ = Phase::kStopping;
  link_.urgent(command("SetActive(1,0)"), now_us, fx);
  if (link_.suspect()) link_.push(command("SetActive(1,0)"));  // the first answer is drained
  if (!config_.trigger_off.empty()) link_.push(command(config_.trigger_off));
  for (const Request& r : held()) link_.push(r);
}

void Microdrop::reply(const Request& request, std::span<const std::byte> line, std::int64_t now_us,
                      Effects& fx) {
  const std::string told = told_by(text_of(line));
  if (request.text().starts_with("GetConfig"))
    identity_ += (request.text().find(",3)") != std::string_view::npos ? " hardware " : ", software ") + told;
  if (obeyed(request, line)) return;
  const std::string why = shown(request) + " is " + told + " instead of " + std::to_string(request.argument);
  if (may_fire_) not_armed_ = why;
  give_up(kInstrument, why, now_us, fx);
}

void Microdrop::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  give_up(kLinkLost, "no good reply to " + shown(request) + not_understood(), now_us, fx);
}

void Microdrop::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (may_fire_ && phase_ != Phase::kSetup)
    fault(Severity::kStop, kLinkLost, "jet: link lost while in use", fx);
  if (may_fire_ && not_armed_.empty()) not_armed_ = "the link was lost while it was armed";
  phase_ = Phase::kDown;
}

bool Microdrop::idle(std::int64_t now_us, Effects& fx) {
  if (phase_ == Phase::kArming) {
    phase_ = Phase::kArmed;
    armed("external trigger", fx);
  } else if (phase_ == Phase::kSetup || phase_ == Phase::kStopping) {
    identified();
    phase_ = Phase::kReady;
    may_fire_ = false;
    set_state(DeviceState::kSafe, "inactive", fx);
    if (op_ == Op::kDisarm) finish_pass({}, fx);
    finish(Outcome::kNone, kLinkLost, not_armed_, fx);  // of an arming that was cut short
  } else if (at_rest() && now_us >= poll_at_us()) {
    link_.push(question("GetFrequency(1)", config_.max_rate_hz));
    return true;
  }
  return false;
}

// Drops of StartGlobal come at the frequency that was set, and SetActive(1,0) ends them.
void Microdrop::fire(int droplets, Service& s) {
  s.begin = {command("SetDrops(1,", droplets), question("GetDrops(1)", droplets),
             command("SetActive(1,1)", Repeat::kNever), command("StartGlobal(1)", Repeat::kNever)};
  s.end = {command("SetActive(1,0)"), command("SetDrops(1,1)")};
}

void Microdrop::jet_for(double seconds, Service& s) {
  fire(std::max(1, int(seconds * config_.max_rate_hz)), s);
}

void Microdrop::strobe(int, int delay_us, Service& s) {
  s.begin = {command("SetStrobe(1,", delay_us), question("GetStrobe(1)", delay_us)};
}

void Microdrop::pulses(const JetPulses& pulses, Service s, Effects&) {
  config_.dwell_v = pulses.dwell_v;
  config_.dwell_us = pulses.dwell_us;
  s.begin = pulse_set();
  for (const Request& r : held()) s.begin.push_back(r);
  run_service(std::move(s));
}

bool Microdrop::obeyed(const Request& asked, std::span<const std::byte> line) const {
  return asked.argument == kUnchecked || number_of(text_of(line)) == asked.argument;
}

}  // namespace firn::drivers
