#include "drivers/stage/ensemble.h"
#include "core/options/number.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace firn::drivers::ensemble {
namespace {

constexpr std::size_t kLongestLine = 200;

}  // namespace

std::string fault_names(std::uint32_t bits) {
  static constexpr const char* kNames[32] = {"position error",
                                             "over-current",
                                             "CW end of travel",
                                             "CCW end of travel",
                                             "CW soft limit",
                                             "CCW soft limit",
                                             "amplifier",
                                             "position feedback",
                                             "velocity feedback",
                                             "hall sensor",
                                             "maximum velocity",
                                             "emergency stop",
                                             "velocity error",
                                             nullptr,
                                             nullptr,
                                             "external",
                                             nullptr,
                                             "motor temperature",
                                             "amplifier temperature",
                                             "encoder",
                                             "communication lost",
                                             nullptr,
                                             nullptr,
                                             "feedback scaling",
                                             "marker search",
                                             nullptr,
                                             nullptr,
                                             "voltage clamp",
                                             "power supply",
                                             nullptr,
                                             "internal",
                                             nullptr};
  std::string out;
  for (int b = 0; b < 32; ++b)
    if (bits >> b & 1u) {
      if (!out.empty()) out += ", ";
      out += kNames[b] ? kNames[b] : "bit " + std::to_string(b);
    }
  return out.empty() ? "none" : out;
}

std::string task_question(std::string_view program) {
  constexpr std::string_view kRun = "RUN ";
  const std::size_t at = program.find(kRun);
  if (at == std::string_view::npos) return {};
  std::string_view task = program.substr(at + kRun.size());
  task = task.substr(0, task.find_first_not_of("0123456789"));
  return task.empty() ? std::string() : "TASKSTATE(" + std::string(task) + ")";
}

std::optional<double> Reply::number() const { return whole_number<double>(value); }

std::optional<std::uint32_t> Reply::bits() const {
  const auto v = whole_number<std::int64_t>(value);
  if (!v || *v < -(std::int64_t(1) << 31) || *v >= (std::int64_t(1) << 32)) return std::nullopt;
  return std::uint32_t(*v);
}

EnsembleDialect::EnsembleDialect() {
  timeouts.reply_us = 2'000'000;
  timeouts.read_us = 200'000;
  timeouts.quiet_us = 300'000;
  timeouts.lock_us = 10'000'000;
}

Frame EnsembleDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view text = text_of(buffer);
  const std::size_t end = text.find(table.terminator);
  if (end == std::string_view::npos)
    return text.size() > kLongestLine ? Frame{Frame::Kind::kCorrupt, text.size()} : Frame{};
  const std::size_t size = end + 1;
  if (size > kLongestLine) return {Frame::Kind::kCorrupt, size};
  std::string_view line = text.substr(0, end);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  const bool known = !line.empty() && (line[0] == table.ok || line[0] == table.nak ||
                                       line[0] == table.fault || line[0] == table.timeout);
  if (!awaited) return {Frame::Kind::kUnsolicited, size};
  if (!known) return {Frame::Kind::kCorrupt, size};
  if (line[0] == table.ok) {
    // A bare '%' line may precede the value (EPICS reads again); a value that was not asked for means that
    // replies and requests are out of step.
    if (awaited->format != kAcknowledge && line.size() == 1) return {Frame::Kind::kIgnore, size};
    if (awaited->format == kAcknowledge && line.size() > 1) return {Frame::Kind::kCorrupt, size};
    if (awaited->format == kValue && !parse(buffer.first(size)).number())
      return {Frame::Kind::kCorrupt, size};
  }
  return {Frame::Kind::kReply, size};
}

Request EnsembleDialect::probe() const {
  return Line(table, Repeat::kRead, 0, kValue).text("PLANESTATUS(0)").done();
}

Reply EnsembleDialect::parse(std::span<const std::byte> frame) const {
  std::string_view line = text_of(frame);
  if (!line.empty() && line.back() == table.terminator) line.remove_suffix(1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  Reply r;
  if (line.empty()) return r;
  r.kind = line[0] == table.nak       ? Reply::Kind::kNak
           : line[0] == table.fault   ? Reply::Kind::kFault
           : line[0] == table.timeout ? Reply::Kind::kTimeout
                                      : Reply::Kind::kOk;
  r.value = line.substr(1);
  return r;
}

Line::Line(const Table& table, Repeat repeat, std::uint16_t tag, Format format) : table_(table) {
  request_.repeat = repeat;
  request_.tag = tag;
  request_.format = format;
}

Line& Line::text(std::string_view text) {
  request_.append(text);
  return *this;
}

Line& Line::axis(int axis) { return text("@").integer(axis); }

Line& Line::integer(std::int64_t value) {
  char buffer[24];
  const auto r = std::to_chars(buffer, buffer + sizeof buffer, value);
  return text({buffer, std::size_t(r.ptr - buffer)});
}

Line& Line::fixed4(double value) { return fixed(value, 4, 1e4); }

Line& Line::fixed9(double value) { return fixed(value, 9, 1e9); }

Line& Line::fixed(double value, int decimals, double unit) {
  if (!(std::abs(value) < 1e9))
    throw std::domain_error("a number for the stage controller is not finite or too large");
  char buffer[40];
  const double rounded = std::round(value * unit) / unit;
  const auto r = std::to_chars(buffer, buffer + sizeof buffer, rounded == 0.0 ? 0.0 : rounded,
                               std::chars_format::fixed, decimals);
  std::string_view digits(buffer, std::size_t(r.ptr - buffer));
  while (digits.back() == '0') digits.remove_suffix(1);
  if (digits.back() == '.') digits.remove_suffix(1);
  return text(digits);
}

Request Line::done() {
  request_.append(std::string_view(&table_.terminator, 1));
  return request_;
}

Line& with_axis(Line& line, std::string_view text, int axis) {
  const std::size_t at = text.find('@');
  if (at == std::string_view::npos) return line.text(text);
  return line.text(text.substr(0, at)).axis(axis).text(text.substr(at + 1));
}

Request question(const Table& table, std::string_view verb, int axis, std::uint16_t tag) {
  Line line(table, Repeat::kRead, tag, kValue);
  Request r = with_axis(line, verb, axis).done();
  r.argument = axis;
  return r;
}

Request setting(const Table& table, std::string_view verb, int axis, std::string_view rest,
                std::uint16_t tag) {
  Line line(table, Repeat::kSetup, tag);
  Request r = with_axis(line, verb, axis).text(rest).done();
  r.argument = axis;
  return r;
}

LinkProbe link_probe() {
  return {"an Aerotech stage", "NONE\n",
          [](std::string_view s) {
            return s.size() >= 2 && s.size() < 200 && std::string_view("%!#$").find(s[0]) != s.npos &&
                   s.back() == '\n';
          },
          '\n'};
}

}  // namespace firn::drivers::ensemble
