#include "files/path/feed_path.h"

#include <algorithm>
#include <utility>

namespace firn {

void FeedPath::start(std::string place, Point2 at, double z_mm) {
  path_.place = std::move(place);
  path_.path.z_mm = z_mm;
  path_.path.points.push_back(at);
}

void FeedPath::add(Point2 p, double feed_mm_s) {
  if (p == path_.path.points.back()) return;
  length_mm_ += distance(path_.path.points.back(), p);
  path_.path.points.push_back(p);
  feeds_.push_back(feed_mm_s);
}

/// A speed limit holds up to the next point: where the feed changes, a point on the faster line near the
/// end confines the slower one.
void FeedPath::part_feeds() {
  constexpr double kBeside_mm = 0.5;
  const std::vector<Point2> points = std::move(path_.path.points);
  const std::vector<double> feeds = std::move(feeds_);
  path_.path.points = {points.front()};
  feeds_.clear();
  std::vector<std::size_t> moved{0};  // where each point is now
  for (std::size_t i = 0; i < feeds.size(); ++i) {
    const Point2 &a = points[i], &b = points[i + 1];
    const double length = distance(a, b);
    const auto put = [&](Point2 p) {
      path_.path.points.push_back(p);
      feeds_.push_back(feeds[i]);
    };
    const auto at = [&](double s) {
      return Point2{a.x_mm + s / length * (b.x_mm - a.x_mm), a.y_mm + s / length * (b.y_mm - a.y_mm)};
    };
    const bool parts = length > 4.0 * kBeside_mm;  // no chord of an arc or a spline
    if (parts && i > 0 && feeds[i - 1] < feeds[i]) put(at(kBeside_mm));
    if (parts && i + 1 < feeds.size() && feeds[i + 1] < feeds[i]) put(at(length - kBeside_mm));
    put(b);
    moved.push_back(path_.path.points.size() - 1);
  }
  for (GivenCurve& curve : path_.given) {
    curve.first = moved[curve.first];
    curve.last = moved[curve.last];
  }
}

InputPath FeedPath::take() {
  if (std::ranges::any_of(feeds_, [](double f) { return f < motion::kUnlimited; })) {
    part_feeds();
    auto& speed = path_.speed_limit.point_mm_s;
    speed.assign(1, feeds_.front());
    for (std::size_t i = 0; i < feeds_.size(); ++i)
      speed.push_back(i + 1 < feeds_.size() ? std::min(feeds_[i], feeds_[i + 1]) : feeds_[i]);
  }
  feeds_.clear();
  length_mm_ = 0.0;
  return std::exchange(path_, InputPath());
}

}  // namespace firn
