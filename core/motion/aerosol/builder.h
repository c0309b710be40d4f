// PlanBuilder computes an aerosol plan piece by piece, in order of time. From the first refusal on it
// collects refusals instead of pieces.
#pragma once

#include "core/motion/aerosol/plan.h"
#include "core/motion/aerosol/rounding.h"

namespace firn::motion {

class PlanBuilder {
 public:
  explicit PlanBuilder(const AerosolMachine& machine) : machine_(machine) {}
  void begin(const Point2& start);  ///< at rest, time 0

  /// Shutter closed, minimum time (IV), not shorter than at_least_s.
  void transit(PieceKind kind, std::int32_t segment, const Point2& to, const Point2& v1, double at_least_s);
  /// Shutter open, in the given time (III); refused where the trapezoids have no solution or need more than
  /// v_max.
  void print(std::int32_t segment, const Point2& to, const Point2& v0, const Point2& v1, double duration_s);
  /// Shutter open, the blends about `corner`.
  void round(std::int32_t segment, const Point2& corner, const Rounding& rounding);

  double time_s() const { return t_s_; }
  Point2 position() const { return p_; }
  AerosolPlan finish();

 private:
  void append(PieceKind kind, std::int32_t segment, const PlaneMove& move);
  void append(const Piece& piece);
  void refuse(std::int32_t segment, std::string reason);

  const AerosolMachine& machine_;
  AerosolPlan plan_;
  double t_s_ = 0.0;
  Point2 p_, v_;
};

}  // namespace firn::motion
