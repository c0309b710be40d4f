#include "plant/twins/fvp.h"

#include <cmath>
#include <initializer_list>
#include <numbers>

#include "core/options/number.h"

namespace firn::plant::fvp {

namespace {

/// Counts of a rad or a mm.
constexpr double kRad = 1e4 * 180.0 / std::numbers::pi, kMm = 1e3;
constexpr Joints kCounts{kRad, kRad, kMm, kRad};

std::string joined(std::initializer_list<std::int64_t> numbers) {
  std::string text;
  for (const std::int64_t n : numbers) text += ' ' + std::to_string(n);
  return text;
}

}  // namespace

std::string_view word_of(State state) {
  switch (state) {
    case State::kBoot:
      return "BOOT";
    case State::kIdle:
      return "IDLE";
    case State::kReady:
      return "READY";
    case State::kLoading:
      return "LOADING";
    case State::kRunning:
      return "RUNNING";
    case State::kHold:
      return "HOLD";
    case State::kFault:
      return "FAULT";
    case State::kEstop:
      return "ESTOP";
  }
  return "";
}

std::optional<Request> request_of(std::string_view line) {
  if (line.size() > kLongestLine || !line.starts_with('@')) return std::nullopt;
  const auto text = unsealed(line.substr(1));
  if (!text) return std::nullopt;
  const std::size_t space = text->find(' ');
  if (space == std::string_view::npos) return std::nullopt;
  Request request;
  request.text = text->substr(space + 1);
  const auto number = whole_number<std::int64_t>(text->substr(0, space), 0, kMaxNumber);
  if (!number || request.text.empty()) return std::nullopt;
  request.number = *number;
  return request;
}

bool is_newer(std::int64_t number, std::int64_t last) {
  const std::int64_t ahead = number > last ? number - last : number - last + kMaxNumber;
  return number != last && ahead <= 32767;
}

std::string reply_line(std::int64_t number, std::string_view text) {
  return '@' + sealed(std::to_string(number) + ' ' + std::string(text));
}
std::string event_line(std::int64_t number, std::string_view text) {
  return '!' + sealed(std::to_string(number) + " EVT " + std::string(text));
}
std::string refused(Nak code, std::string_view reason) {
  return "NAK " + std::to_string(int(code)) + ' ' + std::string(reason);
}

Joints joints_at(const Point& point) {
  Joints joints;
  for (std::size_t n = 0; n < joints.size(); ++n) joints[n] = point[n] / kCounts[n];
  return joints;
}

Point nearest_point(const Joints& joints) {
  Point point{};
  for (std::size_t n = 0; n < point.size(); ++n) point[n] = std::int32_t(std::lround(joints[n] * kCounts[n]));
  return point;
}

std::optional<Point> next_point(Words& words) {
  Point point{};
  for (std::int32_t& count : point) count = std::int32_t(words.integer(-kMaxCount, kMaxCount));
  return words.good() ? std::optional(point) : std::nullopt;
}

std::string text_of(const Point& point) { return joined({point[0], point[1], point[2], point[3]}).substr(1); }

std::uint16_t checksum(std::span<const Point> points) {
  RemainderCcitt sum;
  for (const Point& point : points) {
    if (&point != points.data()) sum.add(" ");
    sum.add(text_of(point));
  }
  return sum.value();
}

std::string text_of(const Report& r) {
  return std::string(word_of(r.state)) +
         joined({r.state_1, r.state_2, r.boots, r.power, r.calibrated, r.speed_percent, r.error,
                 r.running_path, r.points_passed, r.ended_path, r.reached_end, r.ended_ms, r.slots[0],
                 r.slots[1]});
}

}  // namespace firn::plant::fvp
