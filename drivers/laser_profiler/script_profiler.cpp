#include "drivers/laser_profiler/script_profiler.h"

#include <cmath>
#include <utility>
#include <vector>

namespace firn::drivers {
namespace {

constexpr int kMostRows = 1'000'000;
constexpr double kMost_mm = 1e4;

}  // namespace

ScriptProfiler::ScriptProfiler(ScriptOptions script, LaserProfilerOptions config, double counts_per_mm)
    : ScriptDriver(std::move(script), {"arm", "rows", "end"}),
      config_(config),
      counts_per_mm_(counts_per_mm) {
  check_options("laser_profiler", kLaserProfilerConfig, config_);
}

void ScriptProfiler::arm(int rows, std::int64_t now_us, Effects& fx) {
  if (accepts(fx)) {
    if (rows < 1 || rows > kMostRows) {
      refuse(kLimit, "a scan of " + std::to_string(rows) + " rows", fx);
    } else {
      begin_command();
      rows_ = rows;
      received_ = 0;
      set_state(DeviceState::kStaged, "arming", fx);
      call(kArm, "arm", {{"rows", {double(rows)}}}, now_us);
    }
  }
  pump(now_us, fx);
}

void ScriptProfiler::end(std::int64_t now_us, Effects& fx) {
  if (accepts(fx)) begin_command();  // rows() is asked once more, then end()
  pump(now_us, fx);
}

bool ScriptProfiler::work(std::int64_t now_us, Effects&) {
  if (busy()) {
    if (scanning_)
      call(kRows, "rows", {}, now_us);
    else
      call(kEnd, "end", {}, now_us);
    return true;
  }
  if (!scanning_ || now_us < ask_us_) return false;
  call(kRows, "rows", {}, now_us);
  return true;
}

void ScriptProfiler::returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) {
  switch (tag) {
    case kArm:
      scanning_ = true;
      ask_us_ = now_us;
      set_state(DeviceState::kArmed, "waiting for triggers", fx);
      return finish({Outcome::kReady, received_, rows_, 0, 0, kNoCode, ""}, fx);
    case kRows:
      ask_us_ = now_us + std::int64_t(config_.poll_s * 1e6);
      if (const std::string why = take(line, fx); !why.empty()) return wrong("rows", why, now_us, fx);
      if (received_ >= rows_ || busy()) scan_over(fx);
      if (!scanning_ && !busy()) set_state(DeviceState::kSafe, "scan complete", fx);
      return;
    case kEnd:
      scan_over(fx);
      set_state(DeviceState::kSafe, "scan ended", fx);
      return finish({Outcome::kDone, received_, rows_, 0, 0, kNoCode, ""}, fx);
    default:
      return;
  }
}

std::string ScriptProfiler::take(const Line& line, Effects& fx) {
  const auto z = line.values.find("z_mm"), row = line.values.find("row"), y = line.values.find("y_mm");
  if (z == line.values.end() && row == line.values.end()) return {};  // none is new
  if (z == line.values.end() || row == line.values.end() || y == line.values.end())
    return "it returns no \"row\", \"y_mm\" and \"z_mm\"";
  const std::size_t n = row->second.size();
  const double x0_mm = line.number("x0_mm"), dx_mm = line.number("dx_mm");
  if (n == 0) return {};
  if (y->second.size() != n || z->second.size() % n != 0 || z->second.size() / n < 2)
    return std::to_string(n) + " rows, " + std::to_string(y->second.size()) + " y_mm and " +
           std::to_string(z->second.size()) + " z_mm do not belong together";
  if (!(std::abs(x0_mm) <= kMost_mm && dx_mm > 0.0 && dx_mm <= kMost_mm))
    return "x0_mm or dx_mm is no length";
  const std::size_t points = z->second.size() / n;
  for (std::size_t k = 0; k < n; ++k) {
    const double number = row->second[k], y_mm = y->second[k];
    if (!(number >= 0.0 && number < double(rows_)) || number != std::floor(number))
      return "row " + std::to_string(number) + " is no row of this scan of " + std::to_string(rows_);
    if (!(std::abs(y_mm) <= kMost_mm)) return "y_mm = " + std::to_string(y_mm) + " is no length";
    ProfileRow p{std::int32_t(number),
                 x0_mm,
                 dx_mm,
                 std::uint32_t(number) + 1,
                 std::int32_t(std::lround(y_mm * counts_per_mm_)),
                 {z->second.begin() + std::ptrdiff_t(k * points),
                  z->second.begin() + std::ptrdiff_t((k + 1) * points)}};
    ++received_;
    fx.measured<ProfilerDriver>(std::move(p));
  }
  return {};
}

void ScriptProfiler::scan_over(Effects& fx) {
  if (!std::exchange(scanning_, false)) return;
  fx.measured<ProfilerDriver>(ScanDone{rows_, received_});
}

void ScriptProfiler::became_safe(std::int64_t, Effects& fx) {
  scan_over(fx);
  if (ending() == kStopped) finish({Outcome::kDone, received_, rows_, 0, 0, kNoCode, ending()}, fx);
}

Result ScriptProfiler::broken_off(Outcome outcome, std::int32_t code, std::string text) {
  return {outcome, received_, rows_, 0, 0, code, std::move(text)};
}

}  // namespace firn::drivers
