// svg::PathMaker makes the paths of a file from the lines and curves of its shapes.
#pragma once

#include <cstdint>
#include <string>

#include "files/path/path_file.h"
#include "files/path/svg_shapes.h"

namespace firn::svg {

/// A rectangle outside of which nothing is drawn.
struct Cut {
  PlaneTransform from_mm;
  double x = 0.0, y = 0.0, width = 0.0, height = 0.0;
  std::string what;  ///< "<svg>" or "clip-path"
  std::size_t line = 0;
  const Cut* outer = nullptr;
};

class PathMaker {
 public:
  explicit PathMaker(const PathSink& sink);
  PathMaker(const PathMaker&) = delete;
  PathMaker& operator=(const PathMaker&) = delete;

  /// @param place for messages @param fraction of the file read so far @param cut the innermost one, or none
  void begin_shape(const std::string& place, double fraction, const Cut* cut);
  /// Hands the shape's last path out. False if the shape has no path with a length.
  bool finish_shape();
  /// Receives the shape. @throws SyntaxError for a point beyond a cut or the limit, and for too many
  const Target& target() const { return target_; }
  std::int64_t count() const { return count_; }

 private:
  void begin(Point2 p);
  void add(Point2 p);
  void add_bezier(Point2 b, Point2 c, Point2 d);
  void add_arc(Point2 centre, double side, Point2 to);
  void check(Point2 p) const;
  void finish();
  Point2 last() const { return path_.path.points.back(); }

  const PathSink& sink_;
  Target target_;
  InputPath path_;
  std::string place_;
  double fraction_ = 0.0;
  const Cut* cut_ = nullptr;
  std::int64_t count_ = 0, before_ = 0;
};

}  // namespace firn::svg
