// ShapeChoice plans the motion between two stops along the curve whose shape is fastest.
#pragma once

#include <vector>

#include "core/motion/certified/curve_descent.h"
#include "core/motion/certified/segment_curve.h"
#include "core/motion/certified/speed_planner.h"

namespace firn::motion {

/// Buffers kept between paths.
struct SegmentWork {
  SegmentCurve curve;
  SpeedPlanner speed;
  DescentWork descent;
  StopSegment other;              ///< along another shape
  TimedMotion straight;           ///< on a line of the same length
  std::vector<GivenCurve> given;  ///< of a part
};

class ShapeChoice {
 public:
  ShapeChoice(const CleanPath& path, const CertifiedTask& task, SegmentWork& work)
      : path_(path), task_(task), work_(work) {}

  /// Plans between two stops, points of the path.
  /// @param max_s without a tolerance a motion that is slower may be left unplanned: its duration is
  /// unlimited
  void plan(std::size_t from, std::size_t to, StopSegment& out, double max_s = kNoMaxDuration_s);

  /// Plans along the one shape that the points suggest, without comparison.
  void plan_likely(std::size_t from, std::size_t to, StopSegment& out);

  /// Plans along the chord between two points, and measures the deviation from the path between them.
  void plan_chord(std::size_t from, std::size_t to, StopSegment& out);

  /// Time between two rests if the path were straight, `scale` times as long.
  double straight_time_s(std::size_t from, std::size_t to, double scale);

 private:
  /// Cases of the search for the fastest shape.
  enum class Case {
    kOneShape,        ///< no tolerance, or a tool that turns: the curve is where the points say
    kHeldSamples,     ///< held samples of a free-form curve: two shapes pass them
    kWithinTolerance  ///< any shape within the tolerance will do
  };
  Case case_of(bool free_form) const;
  void plan_held(const PathPart& part, double max_s, StopSegment& out);
  void plan_within_tolerance(const PathPart& part, bool free_form, StopSegment& out);

  PathPart part_of(std::size_t from, std::size_t to) { return motion::part_of(path_, from, to, work_.given); }
  bool free_form(const PathPart& part);
  /// Plans along the curve of one shape. A fitted curve moves where the time saved is worth it.
  void plan_shape(const PathPart& part, Shape shape, const MaxDuration& max, StopSegment& out);
  void plan_still(const PathPart& part, Shape shape, const MaxDuration& max, StopSegment& out);

  const CleanPath& path_;
  const CertifiedTask& task_;
  SegmentWork& work_;
};

}  // namespace firn::motion
