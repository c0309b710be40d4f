// Where along stretches that lack the next level the medial axis is asked for.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stretches.h"
#include "core/slice/medial/middle_lines.h"
#include "core/slice/medial/next_level.h"

namespace firn::slice {

/// Keeps its working memory.
class Feet {
 public:
  explicit Feet(NextLevel& next) : next_(next) {}

  /// A foot's spot of the least radius, where it touches what is covered, has its centre `spot_at` inward of
  /// it.
  /// @param limit how far apart the levels run, and what they are drawn
  /// @param enough spots whose centre is no further from the next level are none
  /// @param cores whether the stretches are of cores: in their tips only a foot beside them sees what is left
  void begin(double limit, double spot_at, double enough, bool cores);
  void clear();
  /// The walls of a stretch, and feet on it.
  void add(std::span<const Vec> points, const Stretches::Stretch& stretch);
  void add_walls(std::span<const Vec> points, const Stretches::Stretch& stretch);

  std::vector<Wall> walls;
  std::vector<Foot> feet;

 private:
  bool served(Vec spot);
  void stand(Vec at, Vec normal, double order);
  void stand_at_corner(std::size_t edge, std::size_t before);
  void stand_along(std::size_t edge);

  NextLevel& next_;
  double limit_ = 0, spot_at_ = 0, enough_ = 0;
  bool cores_ = false;
  bool begun_ = false;  // has the run a foot?
  Vec last_at_, last_tip_;
  std::size_t first_wall_ = 0;  // of the stretch
  const Stretches::Stretch* stretch_ = nullptr;
  std::int32_t run_ = 0;
  double way_ = 0;  // along all walls
};

}  // namespace firn::slice
