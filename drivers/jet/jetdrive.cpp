#include "drivers/jet/jetdrive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace firn::drivers::jetdrive {
namespace {

constexpr std::uint8_t kStart = 'S';
constexpr double kSlopeLimit_v_us = 30.0;
constexpr std::size_t kLongestPrompt = 200;  // the boot monitor's answer to Q has 35 or 49 bytes

std::uint8_t at(std::span<const std::byte> bytes, std::size_t n) { return std::uint8_t(bytes[n]); }

void put16(std::array<std::uint8_t, 19>& data, std::size_t n, int value) {
  data[n] = std::uint8_t(unsigned(value) >> 8);
  data[n + 1] = std::uint8_t(value);
}

int tenths(double us) { return int(us * 10.0 + 0.001); }

int slope_tenths(double us, int from_v, int to_v) {
  return std::max(tenths(us), int(std::abs(to_v - from_v) / kSlopeLimit_v_us * 10.0) + 10);
}

}  // namespace

Waveform waveform_of(const JetConfig& c) {
  return {int(c.idle_v), int(c.dwell_v), int(c.echo_v), c.rise_us,
          c.dwell_us,    c.fall_us,      c.echo_us,     c.final_us};
}

Waveform small_waveform_of(const JetConfig& c) {
  Waveform w = waveform_of(c);
  w.dwell_v = int(c.small_dwell_v);
  w.echo_v = int(c.small_echo_v);
  return w;
}

Violation waveform_refusal(const Waveform& w, const JetDialect& limits) {
  char text[120];
  const struct {
    const char* name;
    int v;
  } volts[] = {{"idle", w.idle_v}, {"dwell", w.dwell_v}, {"echo", w.echo_v}};
  for (const auto& v : volts)
    if (std::abs(v.v) > limits.max_abs_v) {
      std::snprintf(text, sizeof text, "%s voltage %d V is beyond +-%d V", v.name, v.v, limits.max_abs_v);
      return {text, {double(v.v), double(limits.max_abs_v), "V"}};
    }
  const struct {
    const char* name;
    double us;
  } times[] = {{"rise", w.rise_us},
               {"dwell", w.dwell_us},
               {"fall", w.fall_us},
               {"echo", w.echo_us},
               {"final", w.final_us}};
  const double limit = std::min(limits.max_time_us, 6553.5);
  for (const auto& t : times)
    if (!(t.us >= 0.0 && t.us <= limit)) {
      std::snprintf(text, sizeof text, "%s time %g us is outside [0, %g] us", t.name, t.us, limit);
      return {text, {t.us, limit, "us"}};
    }
  return {};
}

Request frame(Command command, std::span<const std::uint8_t> data, Repeat repeat) {
  Request r;
  r.repeat = repeat;
  r.format = command == Command::kGetVersion ? kVersion : kReply;
  r.argument = int(command);
  std::uint8_t head[3] = {kStart, std::uint8_t(data.size() + 2), std::uint8_t(command)};
  std::uint8_t sum = std::uint8_t(head[1] + head[2]);
  for (const std::uint8_t b : data) sum = std::uint8_t(sum + b);
  r.append(std::as_bytes(std::span(head)));
  r.append(std::as_bytes(data));
  r.append(std::as_bytes(std::span(&sum, 1)));
  return r;
}

Request pulse(const Waveform& w) {
  std::array<std::uint8_t, 19> d{};
  put16(d, 2, tenths(w.dwell_us));
  put16(d, 5, tenths(w.echo_us));
  put16(d, 7, w.idle_v);
  put16(d, 9, w.dwell_v);
  put16(d, 11, w.echo_v);
  put16(d, 13, slope_tenths(w.rise_us, w.idle_v, w.dwell_v));
  put16(d, 15, slope_tenths(w.fall_us, w.dwell_v, w.echo_v));
  put16(d, 17, slope_tenths(w.final_us, w.echo_v, w.idle_v));
  Request r = frame(Command::kPulse, d, Repeat::kSetup);
  r.reply_us = 2'000'000;
  return r;
}

JetDriveDialect::JetDriveDialect() {
  timeouts.reply_us = 500'000;
  timeouts.read_us = 100'000;
  timeouts.quiet_us = 150'000;
  timeouts.lock_us = 5'000'000;
  timeouts.opening_us = 50'000;
}

Frame JetDriveDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  if (!awaited) return {Frame::Kind::kUnsolicited, buffer.size()};
  const std::string_view text(reinterpret_cast<const char*>(buffer.data()), buffer.size());
  if (awaited->format == kEcho) {  // a version 6 may tell more behind its name, of unknown length
    const std::size_t place = text.find(char(awaited->bytes[0]));
    if (place != std::string_view::npos) return {Frame::Kind::kReply, place + 1};
    return text.size() > kLongestPrompt ? Frame{Frame::Kind::kCorrupt, text.size()} : Frame{};
  }
  if (awaited->format == kPrompt) {
    const std::size_t end = text.find('>');
    if (end != std::string_view::npos) return {Frame::Kind::kReply, end + 1};
    const std::size_t name = text.find("MFJET32");
    if (name != std::string_view::npos) return {Frame::Kind::kReply, name + 7};
    return text.size() > kLongestPrompt ? Frame{Frame::Kind::kCorrupt, text.size()} : Frame{};
  }
  if (at(buffer, 0) != layout.ack && at(buffer, 0) != layout.nak) return {Frame::Kind::kCorrupt, 1};
  const auto size = std::size_t(awaited->format == kVersion ? layout.version_size : layout.size);
  if (buffer.size() < size) return {};
  std::uint8_t sum = 0;
  for (std::size_t n = 1; n + 1 < size; ++n) sum = std::uint8_t(sum + at(buffer, n));
  const bool good = sum == at(buffer, size - 1) &&
                    at(buffer, std::size_t(layout.command_at)) == std::uint8_t(awaited->argument);
  return {good ? Frame::Kind::kReply : Frame::Kind::kCorrupt, size};
}

Request JetDriveDialect::probe() const { return jetdrive::frame(Command::kPoll, {}, Repeat::kRead); }

Reply JetDriveDialect::parse(std::span<const std::byte> frame) const {
  const auto version_size = std::size_t(layout.version_size);
  return {at(frame, 0) == layout.ack, at(frame, std::size_t(layout.status_at)),
          frame.size() == version_size ? at(frame, version_size - 2) : std::uint8_t(0)};
}

}  // namespace firn::drivers::jetdrive
