#include "drivers/stage/way_readout.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drivers/stage/stage_tag.h"

namespace firn::drivers {
namespace {

constexpr std::size_t kDglobals = 16384;  // the samples take those behind the knots
constexpr double kMaxSamples = 8192.0;
constexpr double kAfterTheEnd_s = 0.1;  // the program records so much longer than the way is planned
constexpr double kPlausible_mm = 0.02;  // beyond what the way's acceleration explains

}  // namespace

using ensemble::Line;

std::int64_t WayReadout::prepare(const StageWay& way, double wanted_s) {
  followed_ = {};
  first_ = std::int64_t(5 * way.knots.size());
  start_ = way.knots.front();
  counted_ = 0;
  recording_ = wanted_s > 0.0;
  if (!recording_) return 0;
  // Whole milliseconds, so many that the samples of the whole way find room.
  const double room = double((kDglobals - 5 * way.knots.size()) / 2);
  const double min_s = (way.knots.back().t_s + kAfterTheEnd_s) / room;
  const auto period_ms = std::int64_t(std::ceil(std::max(wanted_s, min_s) * 1e3 - 1e-9));
  followed_.period_s = double(period_ms) * 1e-3;
  return period_ms;
}

void WayReadout::begin(const StageWay& way, std::int64_t now_us) {
  followed_.begin_us = now_us;
  double steepest = 0.0;
  for (std::size_t k = 1; k < way.knots.size(); ++k) {
    const WayKnot &a = way.knots[k - 1], &b = way.knots[k];
    const double change = std::abs(b.vx_mm_s - a.vx_mm_s) + std::abs(b.vy_mm_s - a.vy_mm_s);
    steepest = std::max(steepest, change / (b.t_s - a.t_s));
  }
  plausible_mm_ = steepest * followed_.period_s * followed_.period_s + kPlausible_mm;
  counted_for_ = 0;
  again_ = false;
}

std::optional<Request> WayReadout::question(std::int64_t poll_us, const StageConfig& config,
                                            const ensemble::Table& table) {
  if (!recording_) return std::nullopt;
  const auto ask = [&](const char* name, std::int64_t index, std::uint16_t tag) {
    Line line(table, Repeat::kRead, tag, ensemble::kValue);
    Request r = line.text(name).text("(").integer(index).text(")").done();
    r.argument = read_so_far();
    return r;
  };
  if (read_so_far() < 2 * counted_) return ask("DGLOBAL", first_ + read_so_far(), stage_tag::kSample);
  if (counted_for_ == poll_us) return std::nullopt;
  counted_for_ = poll_us;
  return ask("IGLOBAL", config.dialect.path_samples_iglobal, stage_tag::kSamples);
}

void WayReadout::held(double samples) {
  if (samples >= counted_ && samples <= kMaxSamples) counted_ = std::int32_t(samples);
}

void WayReadout::take(std::int32_t index, double value_mm) {
  if (index != read_so_far()) return;
  std::vector<float>& held = index % 2 == 0 ? followed_.x_mm : followed_.y_mm;
  const std::size_t n = held.size();
  const double last = n > 0 ? double(held[n - 1]) : index % 2 == 0 ? start_.x_mm : start_.y_mm;
  const double foreseen = n > 1 ? 2.0 * last - double(held[n - 2]) : last;
  const bool far = std::abs(value_mm - foreseen) > plausible_mm_;
  if (far && !std::exchange(again_, true)) return;  // perhaps a damaged digit: asked once more
  again_ = false;
  held.push_back(float(value_mm));
}

FollowedWay WayReadout::take_followed() {
  followed_.x_mm.resize(followed_.y_mm.size());
  return std::exchange(followed_, {});
}

}  // namespace firn::drivers
