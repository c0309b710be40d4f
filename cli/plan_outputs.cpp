#include "cli/plan_outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "cli/exit_codes.h"

namespace firn {

TextOutput::TextOutput(const std::filesystem::path& file) : file_(file), part_(file.string() + ".part-" + std::to_string(getpid())) {
  out_ = std::fopen(part_.c_str(), "wb");
  if (!out_) throw UsageError(file_.string() + ": cannot be written: " + std::strerror(errno));
}

TextOutput::~TextOutput() {
  if (!out_) return;
  std::fclose(out_);
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void TextOutput::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), out_) != text.size()) throw std::runtime_error(file_.string() + ": " + std::strerror(errno));
}

void TextOutput::finish() {
  const bool flushed = std::fflush(out_) == 0 && fsync(fileno(out_)) == 0;
  const int error = errno;
  const bool closed = std::fclose(out_) == 0;
  out_ = nullptr;
  std::error_code renamed;
  if (flushed && closed) std::filesystem::rename(part_, file_, renamed);
  if (flushed && closed && !renamed) return;
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
  throw std::runtime_error(file_.string() + ": " + (renamed ? renamed.message() : std::strerror(error)));
}

std::string csv_header(const std::vector<std::string>& axis_units) {
  return "t_s,x_mm,y_mm,joint_1_" + axis_units.at(0) + ",joint_2_" + axis_units.at(1) + "\n";
}

std::string csv_lines(const PlannedItem& item) {
  const Trajectory& t = item.result.trajectory;
  fmt::memory_buffer lines;
  lines.reserve(100 * t.samples());
  for (std::size_t n = 0; n < t.samples(); ++n) {
    const Point2& p = item.result.tool[n];
    const double* q = t.positions.data() + n * std::size_t(t.axes);
    fmt::format_to(std::back_inserter(lines), "{:.9g},{},{},{},{}\n", double(n) * t.tick_s, p.x_mm, p.y_mm, q[0], q[1]);
  }
  return fmt::to_string(lines);
}

void take_worst(std::vector<WorstRatio>& worst, const Certificate& certificate, std::int64_t path) {
  for (const LimitRatio& l : certificate.limits) {
    const auto known = std::find_if(worst.begin(), worst.end(), [&](const WorstRatio& w) { return w.ratio.limit == l.limit; });
    if (known == worst.end()) worst.push_back({l, path});
    else if (l.ratio > known->ratio.ratio) *known = {l, path};
  }
}

std::string item_json(const PlannedItem& item) {
  const motion::PlanResult& r = item.result;
  const Certificate& c = r.trajectory.certificate;
  std::string j = fmt::format(
      "{{\"path\":{},\"layer\":{},\"points\":{},\"length_mm\":{},\"samples\":{},\"duration_s\":{},\"continuous_s\":{},"
      "\"lower_bound_s\":{},\"over_lower_bound\":{},\"deviation_mm\":{},\"stops\":{},\"curvature_ramp_mm\":{},\"limits\":[",
      item.input.number, item.input.path.layer, item.input.path.points.size(), item.length_mm, r.trajectory.samples(), c.duration_s,
      r.continuous_s, c.lower_bound_s, c.lower_bound_s > 0.0 ? fmt::format("{}", c.duration_s / c.lower_bound_s) : "null",
      r.deviation_mm, r.stops, c.curvature_ramp_mm);
  for (const LimitRatio& l : c.limits)
    fmt::format_to(std::back_inserter(j), "{}{{\"limit\":\"{}\",\"ratio\":{},\"time_s\":{}}}", &l == c.limits.data() ? "" : ",",
                   l.limit, l.ratio, l.time_s);
  return j + "]}";
}

std::vector<double> speeds_at_ticks(const std::vector<Point2>& tool, double tick_s) {
  const auto step = [&](std::size_t n) { return std::hypot(tool[n + 1].x_mm - tool[n].x_mm, tool[n + 1].y_mm - tool[n].y_mm) / tick_s; };
  std::vector<double> speeds(tool.size(), 0.0);  // at rest at both ends
  for (std::size_t n = 1; n + 1 < tool.size(); ++n) speeds[n] = 0.5 * (step(n - 1) + step(n));
  return speeds;
}

std::vector<std::size_t> stops_of(const std::vector<double>& speed_mm_s) {
  constexpr std::size_t kAround = 4;  // ticks in which a motion that rests is well under way again
  constexpr double kStill_mm_s = 1.0;
  std::vector<std::size_t> stops;
  for (std::size_t n = 1; n + 1 < speed_mm_s.size(); ++n) {
    if (!(speed_mm_s[n] < kStill_mm_s && speed_mm_s[n] <= speed_mm_s[n - 1] && speed_mm_s[n] < speed_mm_s[n + 1])) continue;
    const auto from = speed_mm_s.begin() + std::ptrdiff_t(n > kAround ? n - kAround : 0);
    const auto to = speed_mm_s.begin() + std::ptrdiff_t(std::min(n + kAround + 1, speed_mm_s.size()));
    if (speed_mm_s[n] <= 0.5 * *std::max_element(from, to)) stops.push_back(n);
  }
  return stops;
}

deposition::PulsePlan nominal_pulses(const PlannedItem& item, const ValveConfig& valve) {
  const Path& path = item.input.path;
  deposition::FlowDemand demand;
  demand.step_s = item.result.trajectory.tick_s;
  demand.speed_mm_s = speeds_at_ticks(item.result.tool, demand.step_s);
  demand.flow_mm3_s.resize(demand.speed_mm_s.size());
  deposition::nominal_flow(path.width_mm, path.layer_height_mm, demand.speed_mm_s, demand.flow_mm3_s);
  demand.stops = stops_of(demand.speed_mm_s);
  const deposition::ValveSetting setting = valve_setting(valve);
  deposition::PulsePlan plan;
  try {
    plan = deposition::plan_pulses(demand, setting, valve_limits(valve));
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(item.input.place + ": " + e.what());
  }
  if (!plan.problem.empty()) throw std::runtime_error(item.input.place + ": " + plan.problem);
  return plan;
}

}  // namespace firn
