// Jet: orders of a person, beside a print (firn device), and what others must know of a JetDrive.
#include "drivers/jet/jet.h"

namespace firn::drivers {

using jetdrive::Command;

namespace {

Request number(Command command, int value, int bytes, Repeat repeat = Repeat::kSetup) {
  const std::uint8_t data[2] = {std::uint8_t(unsigned(value) >> 8), std::uint8_t(value)};
  return jetdrive::frame(command, std::span(data).last(std::size_t(bytes)), repeat);
}

Request soft_trigger() { return jetdrive::frame(Command::kSoftTrigger, {}, Repeat::kNever); }

bool jetdrive_answers(std::string_view s) {
  return s.find('>') != s.npos || s.find("MFJET32") != s.npos ||
         (s.size() == 4 && (s[0] == 0x06 || s[0] == 0x15) && char(s[1] + s[2]) == s[3]);
}

std::vector<Request> jetdrive_questions() {
  Request monitor;  // where it takes single letters
  monitor.append("Q");
  return {jetdrive::frame(Command::kPoll, {}, Repeat::kRead), monitor};
}

}  // namespace

constinit const JetTraits kJetDriveTraits{
    .instrument = "a MicroFab jet",
    .make = &new_jet<Jet>,
    .questions = &jetdrive_questions,
    .answers = &jetdrive_answers,
    .two_sizes = true,
};

void Jet::fire(int droplets, Service& s) {
  take_size(false);
  s.begin = {number(Command::kDrops, droplets, 2), soft_trigger()};
  s.end = {number(Command::kDrops, config_.drops_per_trigger, 2)};
}

void Jet::jet_for(double, Service& s) {
  take_size(false);
  s.begin = {number(Command::kContinuous, 1, 1, Repeat::kNever), soft_trigger()};
  s.end = {number(Command::kContinuous, 0, 1)};
}

void Jet::strobe(int divider, int delay_us, Service& s) {
  const std::uint8_t delay[3] = {0x01, std::uint8_t(unsigned(delay_us) >> 8), std::uint8_t(delay_us)};
  s.begin = {number(Command::kStrobeDivider, divider, 1), number(Command::kStrobeEnable, 1, 1),
             jetdrive::frame(Command::kStrobeDelay, delay, Repeat::kSetup)};
}

void Jet::pulses(const JetPulses& p, Service, Effects& fx) {
  jetdrive::Waveform w = waveform_;
  w.dwell_v = int(p.dwell_v);
  w.echo_v = int(p.echo_v);
  w.dwell_us = p.dwell_us;
  w.echo_us = p.echo_us;
  begin_waveform(w, fx);
}

bool Jet::obeyed(const Request&, std::span<const std::byte> frame) const {
  return dialect_.parse(frame).acknowledged;
}

}  // namespace firn::drivers
