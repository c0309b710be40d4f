#include "core/slice/thin.h"

#include "core/slice/ring_writer.h"

namespace firn::slice {
namespace {

// An edge that grows from an anchor along a line of places: the slopes, seen in the direction in which it set out, at which
// it passes all of them within the tolerance.
class Edge {
 public:
  explicit Edge(double tolerance) : tolerance_(tolerance) {}
  void begin(Vec anchor, Vec place) {
    anchor_ = anchor, place_ = place;
    reach_ = kNoWay;
  }
  // @return whether the edge may go on to a place, or, with a tolerance of 0 there, end at it
  bool take(Vec p, double tolerance) {
    const Vec way = p - anchor_;
    if (reach_ == kNoWay) {
      const Vec out = p - place_;
      if (dot(way, way) <= tolerance_ * tolerance_ || dot(out, out) == 0) return true;
      along_ = (1 / length(out)) * out;
      reach_ = kNothing, slopes_ = Pair{-kSteep, -kSteep};
    }
    const double reach = dot(along_, way), side = cross(along_, way);
    const Pair beside = Pair{side - tolerance, -(side + tolerance)};
    const auto out_of = beside > Pair{-slopes_[1], -slopes_[0]} * reach;
    if ((reach < reach_) | ((out_of[0] | out_of[1]) != 0)) return false;
    const Pair here = beside / reach;
    slopes_ = here > slopes_ ? here : slopes_;
    reach_ = reach;
    return true;
  }
  // Beside the place taken last: as far from either side as it may be.
  Vec end() const { return anchor_ + reach_ * (along_ + 0.5 * (slopes_[0] - slopes_[1]) * left_of(along_)); }
  bool empty() const { return reach_ <= kNothing; }

 private:
  using Pair = double __attribute__((vector_size(16)));
  static constexpr double kSteep = 1.0, kNoWay = -1, kNothing = 1e-300;
  double tolerance_, reach_ = kNoWay;  // kNothing: no place taken yet
  Pair slopes_{};                      // the lowest, and minus the highest
  Vec anchor_, place_, along_;
};

}  // namespace

bool thin_ring(std::span<const Vec> line, double tolerance, Rings& rings, Flat flat) {
  const std::size_t n = line.size();
  RingWriter out(rings, n + 1);
  if ((n > 4 || flat == Flat::kVanishes) && tolerance > 0) {
    out.add(line[0]);
    Edge edge(tolerance);
    Vec from = line[0];
    edge.begin(from, from);
    for (std::size_t i = 1; i <= n;) {
      const Vec to = line[i < n ? i : 0];
      if (edge.take(to, i < n ? tolerance : 0.0)) {
        ++i;
        continue;
      }
      if (edge.empty()) from = to, ++i;
      else from = edge.end();
      out.add(from);
      if (i <= n) edge.begin(from, line[i - 1]);
    }
    if (out.size() >= 3 && out.close() != 0) return true;
    out.clear();
    if (flat == Flat::kVanishes) return false;
  }
  for (const Vec v : line) out.add(v);
  return out.close() != 0;
}

}  // namespace firn::slice
