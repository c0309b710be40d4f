#include "files/path/svg_path_maker.h"

#include <fmt/core.h>

#include <cmath>
#include <utility>

#include "files/path/sampled_shapes.h"

namespace firn::svg {

PathMaker::PathMaker(const PathSink& sink)
    : sink_(sink),
      target_{[this](Point2 p) { begin(p); }, [this](Point2 p) { add(p); },
              [this](Point2 b, Point2 c, Point2 d) { add_bezier(b, c, d); },
              [this](Point2 centre, double side, Point2 to) { add_arc(centre, side, to); }} {}

void PathMaker::begin_shape(const std::string& place, double fraction, const Cut* cut) {
  place_ = place;
  fraction_ = fraction;
  cut_ = cut;
  before_ = count_;
}

bool PathMaker::finish_shape() {
  finish();
  return count_ > before_;
}

void PathMaker::begin(Point2 p) {
  finish();
  check(p);
  path_.place = place_;
  path_.path.points.push_back(p);
}

void PathMaker::add(Point2 p) {
  check(p);
  if (p == last()) return;
  if (path_.path.points.size() == kMaxPathPoints)
    throw SyntaxError(fmt::format("more than {} points in one path", kMaxPathPoints));
  path_.path.points.push_back(p);
}

void PathMaker::add_bezier(Point2 b, Point2 c, Point2 d) {
  const Point2 a = last();
  const std::size_t first = path_.path.points.size() - 1;
  const int samples = sample_bezier(a, b, c, d, [this](Point2 p) { add(p); });
  give_bezier(a, b, c, d, samples, first, path_.path.points.size() - 1, path_.given);
}

void PathMaker::add_arc(Point2 centre, double side, Point2 to) {
  const std::size_t first = path_.path.points.size() - 1;
  const auto exact = sample_arc(last(), to, centre, side, [this](Point2 p) { add(p); });
  give_arc(exact, side, first, path_.path.points.size() - 1, path_.given);
}

void PathMaker::check(Point2 p) const {
  for (const double v : {p.x_mm, p.y_mm})
    if (!(std::abs(v) <= kMaxCoordinate_mm))
      throw SyntaxError(fmt::format("{} mm is beyond the limit of +-{} mm", v, kMaxCoordinate_mm));
  constexpr double kEdge = 1e-6;  // rounding, of the rectangle's sides
  for (const Cut* cut = cut_; cut != nullptr; cut = cut->outer) {
    const Point2 q = cut->from_mm(p);
    const double edge = kEdge * (cut->width + cut->height);
    if (!(q.x_mm >= cut->x - edge && q.x_mm <= cut->x + cut->width + edge && q.y_mm >= cut->y - edge &&
          q.y_mm <= cut->y + cut->height + edge))
      throw SyntaxError(
          fmt::format("a shape goes beyond the {} in line {}, which cuts it off there: cut it in the drawing "
                      "program, or remove that",
                      cut->what, cut->line));
  }
}

void PathMaker::finish() {
  if (path_.path.points.size() > 1) {
    path_.number = ++count_;
    path_.fraction = fraction_;
    sink_(std::move(path_));
  }
  path_ = InputPath();
}

}  // namespace firn::svg
