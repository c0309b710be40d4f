#include "core/slice/offset/doubtful_areas.h"

#include <algorithm>

#include "core/geometry/vec.h"

namespace firn::slice {
namespace {

constexpr double kTip = 40;   // thinnings along a ring: what is no further apart faces each other about a tip
constexpr double kEvery = 2;  // thinnings: between places looked at
constexpr int kAcross = 4;    // parts of the way across

class Straits {
 public:
  Straits(const Rings& rings, const MeetingCheck& checked, double facing, double d, ExactTips& tips)
      : rings_(rings), checked_(checked), facing_(facing), d_(d), tips_(tips) {}

  // Places between two edges where the contours leave nothing that is d from them.
  void look_between(MeetingCheck::Pair pair) const {
    if (follows_soon(pair.one, pair.other) || follows_soon(pair.other, pair.one)) return;
    const Vec a = from(pair.one), along = to(pair.one) - a, c = from(pair.other), way = to(pair.other) - c;
    const double square = dot(along, along);
    const int steps = 1 + int(length(way) / (kEvery * tips_.thinned()));
    for (int s = 0; s <= steps; ++s) {
      const Vec p = c + (double(s) / steps) * way, off = p - a;
      const Vec across = a + (std::clamp(dot(off, along), 0.0, square) / square) * along - p;
      if (cross(along, off) > 0 && dot(across, across) <= facing_ * facing_ && !open(p, across))
        tips_.doubts().add(p, d_);
    }
  }

  // In a ring that is too small for straits, of which the contours leave nothing.
  void look_into(std::span<const Point> ring) const {
    double around = 0;
    Vec middle, at = to_vec(ring.back());
    for (const Point p : ring) {
      const Vec next = to_vec(p);
      around += length(next - at);
      if (around > 2 * kTip * tips_.thinned()) return;
      middle = middle + next, at = next;
    }
    middle = (1.0 / double(ring.size())) * middle;
    const auto is_open = [&](Vec p) { return tips_.within(p, d_); };
    if (tips_.doubts().settled(middle, d_) || is_open(middle)) return;
    if (std::none_of(ring.begin(), ring.end(), [&](Point p) { return is_open(0.5 * (middle + to_vec(p))); }))
      tips_.doubts().add(middle, d_);
  }

 private:
  Vec from(std::uint32_t edge) const { return to_vec(rings_.points[edge]); }
  Vec to(std::uint32_t edge) const { return from(checked_.next(edge)); }
  bool follows_soon(std::uint32_t edge, std::uint32_t other) const {
    for (double way = 0; way < kTip * tips_.thinned(); way += length(to(edge) - from(edge)))
      if (edge = checked_.next(edge); edge == other) return true;
    return false;
  }
  bool open(Vec p, Vec across) const {
    if (tips_.doubts().settled(p, d_)) return true;
    for (int k = 0; k <= kAcross; ++k)
      if (tips_.within(p + (double(k) / kAcross) * across, d_)) return true;
    return false;
  }

  const Rings& rings_;
  const MeetingCheck& checked_;
  double facing_, d_;
  ExactTips& tips_;
};

}  // namespace

void doubt_areas(const Rings& rings, const MeetingCheck& checked, double facing, std::span<const Vec> peaks,
                 double d, ExactTips& tips) {
  for (const Vec p : peaks)
    if (!tips.doubts().settled(p, d) && tips.within(p, d - tips.thinned())) tips.doubts().add(p, d);
  const Straits straits(rings, checked, facing, d, tips);
  for (std::size_t r = 0; r < rings.size(); ++r) straits.look_into(rings[r]);
  for (const MeetingCheck::Pair pair : checked.facing()) straits.look_between(pair);
}

}  // namespace firn::slice
