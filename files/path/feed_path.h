// FeedPath gathers the points of one path of G-code, each segment with its feed, and its arcs and splines.
#pragma once

#include <string>
#include <vector>

#include "files/path/path_file.h"

namespace firn {

class FeedPath {
 public:
  bool empty() const { return path_.path.points.empty(); }
  std::size_t points() const { return path_.path.points.size(); }
  double length_mm() const { return length_mm_; }

  void start(std::string place, Point2 at, double z_mm);
  /// A point that repeats the last one is left out.
  void add(Point2 p, double feed_mm_s);
  /// Gives the points from `first` on as an arc or a spline (files/path/sampled_shapes.h).
  std::vector<GivenCurve>& given() { return path_.given; }
  /// Hands out the path, with speed limits if a feed is one, and begins the next.
  InputPath take();

 private:
  void part_feeds();

  InputPath path_;
  std::vector<double> feeds_;  ///< of each segment [mm/s]
  double length_mm_ = 0.0;
};

}  // namespace firn
