#include "plant/twins/point_scan.h"

#include <cmath>
#include <limits>

#include "core/options/number.h"
#include "plant/twins/lkg.h"

namespace firn::plant {

namespace {

constexpr double kPointByte_us = 10.0e6 / 115200.0;
constexpr std::int64_t kLeavePoint_us = 600'000, kSelectPoint_us = 200'000;
constexpr std::int64_t kDarkHead = 1, kStuckValue = 2, kCableOff = 3, kInputBounces = 4, kGaugeBlock = 5;
constexpr double kBlock_mm = 0.5;
constexpr std::size_t kLongestPointLine = 64;

}  // namespace

PointScanTwin::PointScanTwin(const ProfilerParams& params, Look look)
    : ProfileSensor(Port::kProfiler, TwinLink(kPointByte_us, params.latency_us)),
      params_(params),
      look_(std::move(look)) {}

std::string PointScanTwin::value(double height_mm) {
  if (fault_ == kGaugeBlock) height_mm += kBlock_mm;
  if (fault_ == kDarkHead) height_mm = std::numeric_limits<double>::quiet_NaN();
  if (fault_ == kStuckValue && !last_.empty()) return last_;
  return last_ = lkg::value(params_.zero_mm + (params_.upside_down ? -height_mm : height_mm));
}

void PointScanTwin::trigger(std::int64_t t_us, std::int32_t, std::span<const double> z_mm) {
  if (fault_ == kCableOff) return;
  for (int n = 0; n < (fault_ == kInputBounces ? 2 : 1); ++n) {
    ++triggers_;
    if (!communication_) link_.reply("TG,1," + value(z_mm[0]) + "\r", t_us + params_.sampling_us);
  }
}

void PointScanTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    const char c = char(b);
    if (c != '\r') {
      if (line_.size() < kLongestPointLine) line_.push_back(c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c);
      continue;
    }
    const std::string answer = execute(line_, now_us);
    line_.clear();
    link_.reply(answer + "\r", std::max(now_us, busy_until_us_));
  }
}

std::string PointScanTwin::execute(std::string_view command, std::int64_t now_us) {
  const std::string name(command);
  if (command == "Q0" || command == "R0") {
    const bool enter = command == "Q0";
    if (enter == communication_) return lkg::refused(command, lkg::Error::kStatus);  // it is so already
    if (!enter) busy_until_us_ = now_us + kLeavePoint_us;
    communication_ = enter;
    return name;
  }
  if (communication_) return lkg::refused(command, lkg::Error::kStatus);
  if (command == "M1") return "M1," + value(look_(now_us));
  if (command == "PR") return "PR," + std::to_string(program_);
  if (command.starts_with("PW,")) {
    const auto number = whole_number<std::int32_t>(command.substr(3), 0, lkg::kMaxProgram);
    if (!number) return lkg::refused(command, lkg::Error::kParameter);
    program_ = *number;
    busy_until_us_ = now_us + kSelectPoint_us;
    return "PW";
  }
  return lkg::refused(command, lkg::Error::kCommand);
}

void PointScanTwin::trip(std::int64_t, std::int64_t code) { fault_ = code; }

void PointScanTwin::reboot(std::int64_t) {
  ++boot_count_;
  line_.clear();
  communication_ = false;
  program_ = 0;
  busy_until_us_ = 0;
}

void PointScanTwin::io(Archive& a) {
  a.all(boot_count_, line_, last_, program_, communication_, busy_until_us_, fault_, triggers_, link_);
}

}  // namespace firn::plant
