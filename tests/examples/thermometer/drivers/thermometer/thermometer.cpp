#include "drivers/thermometer/thermometer.h"

#include <limits>

#include "core/options/number.h"

namespace firn::drivers {
namespace {

constexpr std::size_t kLongestLine = 16;
constexpr double kLowest_degC = -100.0;
constexpr double kHighest_degC = 400.0;

}  // namespace

std::optional<double> parse_bed_temperature(std::string_view line) {
  if (line == "OPEN") return std::numeric_limits<double>::quiet_NaN();
  return whole_number(line, kLowest_degC, kHighest_degC);
}

ThermometerDialect::ThermometerDialect() {
  timeouts.reply_us = 500'000;
  timeouts.quiet_us = 100'000;
}

Frame ThermometerDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view text = text_of(buffer);
  const std::size_t end = text.find('\n');
  if (end == text.npos && text.size() <= kLongestLine) return {};
  if (end == text.npos) return {Frame::Kind::kCorrupt, text.size()};
  const bool answers = awaited && parse_bed_temperature(text.substr(0, end));
  return {answers ? Frame::Kind::kReply : Frame::Kind::kCorrupt, end + 1};
}

Request ThermometerDialect::probe() const {
  Request r;
  r.append(std::string_view("T?\n"));
  r.repeat = Repeat::kRead;
  return r;
}

LinkProbe thermometer_probe() {
  return {"a thermometer", "T?\n", [](std::string_view s) {
            return is_whole_reply(ThermometerDialect(), ThermometerDialect().probe(), s);
          }};
}

Thermometer::Thermometer(ThermometerOptions options) : Driver(dialect_), options_(options) {
  check_options("thermometer", kThermometerConfig, options_);
  dialect_.allow_host_latency(options.host_latency_s);
}

void Thermometer::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, "asking", fx);
  link_.push(dialect_.probe());
}

void Thermometer::reply(const Request&, std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) {
  const std::string_view line = text_of(frame);
  next_read_us_ = now_us + std::int64_t(options_.poll_s * 1e6);
  reads_ = true;
  identified();
  set_state(DeviceState::kSafe, "reading", fx);
  fx.measured<Thermometer>(BedTemperature{*parse_bed_temperature(line.substr(0, line.size() - 1))});
}

void Thermometer::failed(const Request&, std::int64_t now_us, Effects& fx) {
  reconnect(now_us, fx, "no good reply");
}

void Thermometer::lost(std::int64_t, Effects& fx) {
  if (reads_) fault(Severity::kWarning, kLinkLost, "thermometer: link lost", fx);
  reads_ = false;
}

bool Thermometer::idle(std::int64_t now_us, Effects&) {
  if (!reads_ || now_us < next_read_us_) return false;
  link_.push(dialect_.probe());
  return true;
}

std::int64_t Thermometer::device_wake_us() const { return link_.idle() && reads_ ? next_read_us_ : 0; }

}  // namespace firn::drivers
