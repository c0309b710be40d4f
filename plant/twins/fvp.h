// Reads requests and writes replies of FVP/1 as the robot's V+ program does (docs/devices/robot.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plant/ice/arm.h"
#include "plant/twins/lines.h"

namespace firn::plant::fvp {

inline constexpr std::size_t kLongestLine = 120;  ///< with CR LF
inline constexpr std::size_t kSlots = 2, kPointsALine = 3;
inline constexpr std::int64_t kFewestPoints = 2, kMaxPoints = 8192;
inline constexpr std::int64_t kMaxNumber = 65535;    ///< of a request or an event; 1 follows it
inline constexpr std::int64_t kMaxPath = 9'999'999;  ///< V+ reals hold 24 bits exactly
inline constexpr std::int64_t kMaxCount = (1 << 24) - 1;

enum class Nak : std::uint8_t {
  kChecksum = 10,
  kNumber = 11,
  kState = 20,
  kRange = 21,
  kJointLimit = 22,
  kNotCalibrated = 23,
  kNoPower = 24,
  kMonitorSpeed = 30,
  kMotionError = 31,
  kWatchdog = 40,
};

enum class State : std::uint8_t { kBoot, kIdle, kReady, kLoading, kRunning, kHold, kFault, kEstop };
std::string_view word_of(State state);

struct Request {
  std::int64_t number = 0;  ///< 0: a path line that is not answered
  std::string_view text;
};
/// Returns the request of a line with its CR LF, or nothing for a damaged line.
std::optional<Request> request_of(std::string_view line);
/// True for a number that is ahead of the last one by 1 to 32767, where 1 follows 65535.
bool is_newer(std::int64_t number, std::int64_t last);

std::string reply_line(std::int64_t number, std::string_view text);
std::string event_line(std::int64_t number, std::string_view text);
std::string refused(Nak code, std::string_view reason);

/// Joints in counts: 1e-4 deg, 1e-4 deg, 1e-3 mm, 1e-4 deg.
using Point = std::array<std::int32_t, 4>;
Joints joints_at(const Point& point);       ///< @returns rad, rad, mm, rad
Point nearest_point(const Joints& joints);  ///< @param joints rad, rad, mm, rad
/// Returns the next four numbers, or nothing where one of them is missing or not a count.
std::optional<Point> next_point(Words& words);
std::string text_of(const Point& point);  ///< one space between two numbers
/// The CRC that PATH END must name: over all numbers in order, one space between any two.
std::uint16_t checksum(std::span<const Point> points);

/// Fields of the reply to STAT, in its order.
struct Report {
  State state = State::kBoot;
  std::int32_t state_1 = 0, state_2 = 0;  ///< V+ STATE(1), STATE(2)
  std::uint32_t boots = 0;
  bool power = false, calibrated = false;
  std::int32_t speed_percent = 100, error = 0;
  std::int32_t running_path = 0, points_passed = 0;
  std::int32_t ended_path = 0;  ///< the one that ended last
  bool reached_end = false;
  std::int32_t ended_ms = 0;
  std::array<std::int32_t, kSlots> slots{};  ///< path verified in each, or 0
};
std::string text_of(const Report& report);

}  // namespace firn::plant::fvp
