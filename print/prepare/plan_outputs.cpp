#include "print/prepare/plan_outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "files/record/file.h"
#include "files/record/output_target.h"
#include "files/usage_error.h"

namespace firn {

namespace {

std::filesystem::path target_of(const std::filesystem::path& file) {
  try {
    return record::output_target(file);
  } catch (const record::FileError& e) {
    throw UsageError(e.what());
  }
}

}  // namespace

TextOutput::TextOutput(const std::filesystem::path& file)
    : file_(target_of(file)), part_(file_.string() + ".part-" + std::to_string(getpid())) {
  out_ = std::fopen(part_.path().c_str(), "wb");
  if (!out_) throw UsageError(file_.string() + ": cannot be written: " + std::strerror(errno));
}

TextOutput::~TextOutput() {
  if (!out_) return;
  std::fclose(out_);
  part_.remove();
}

void TextOutput::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), out_) != text.size())
    throw std::runtime_error(file_.string() + ": " + std::strerror(errno));
}

void TextOutput::finish() {
  const bool flushed = std::fflush(out_) == 0 && fsync(fileno(out_)) == 0;
  const int error = errno;
  const bool closed = std::fclose(out_) == 0;
  out_ = nullptr;
  std::error_code renamed;
  if (flushed && closed) std::filesystem::rename(part_.path(), file_, renamed);
  if (flushed && closed && !renamed) return;
  part_.remove();
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
    fmt::format_to(std::back_inserter(lines), "{:.9g},{},{},{},{}\n", double(n) * t.tick_s, p.x_mm, p.y_mm,
                   q[0], q[1]);
  }
  return fmt::to_string(lines);
}

void take_worst(std::vector<WorstRatio>& worst, const Certificate& certificate, std::int64_t path) {
  for (const LimitRatio& l : certificate.limits) {
    const auto known = std::find_if(worst.begin(), worst.end(),
                                    [&](const WorstRatio& w) { return w.ratio.limit == l.limit; });
    if (known == worst.end())
      worst.push_back({l, path});
    else if (l.ratio > known->ratio.ratio)
      *known = {l, path};
  }
}

std::string item_json(const PlannedItem& item) {
  const motion::PlanResult& r = item.result;
  const Certificate& c = r.trajectory.certificate;
  std::string j = fmt::format(
      "{{\"path\":{},\"layer\":{},\"points\":{},\"length_mm\":{},\"samples\":{},\"duration_s\":{},"
      "\"continuous_s\":{},"
      "\"lower_bound_s\":{},\"over_lower_bound\":{},\"deviation_mm\":{},\"stops\":{},\"curvature_ramp_mm\":{}"
      ",\"limits\":[",
      item.input.number, item.input.path.layer, item.input.path.points.size(), item.length_mm,
      r.trajectory.samples(), c.duration_s, r.continuous_s, c.lower_bound_s,
      c.lower_bound_s > 0.0 ? fmt::format("{}", c.duration_s / c.lower_bound_s) : "null", r.deviation_mm,
      r.stops, c.curvature_ramp_mm);
  if (r.held_mm > 0.0)
    j.insert(j.find(",\"limits\""),
             fmt::format(",\"points_off_mm\":{},\"held_mm\":{}", r.points_off_mm, r.held_mm));
  for (const LimitRatio& l : c.limits)
    fmt::format_to(std::back_inserter(j), "{}{{\"limit\":\"{}\",\"ratio\":{},\"time_s\":{}}}",
                   &l == c.limits.data() ? "" : ",", l.limit, l.ratio, l.time_s);
  j += "]";
  if (!item.pulse_plan.trains.empty()) {
    fmt::format_to(std::back_inserter(j), ",\"pulse_lists\":{},\"added_stops\":[",
                   item.pulse_plan.trains.size());
    for (const AddedStop& s : item.added_stops)
      fmt::format_to(std::back_inserter(j), "{}{{\"along_mm\":{},\"x_mm\":{},\"y_mm\":{},\"corner\":{}}}",
                     &s == item.added_stops.data() ? "" : ",", s.along_mm, s.at.x_mm, s.at.y_mm, s.corner);
    j += "]";
  }
  return j + "}";
}

}  // namespace firn
