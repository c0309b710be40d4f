#include "core/slice/medial/middle_lines.h"

#include <algorithm>
#include <limits>

#include "core/geometry/box_search.h"
#include "core/slice/medial/few_walls.h"

namespace firn::slice {
namespace {

constexpr double kFacing =
    -0.174;  // cosine of 100 degrees: walls turned further from each other face each other
constexpr double kNear = 0.1 * kUnitsPerMm;  // places closer together are one
constexpr double kFar = 2.0 * kUnitsPerMm;   // places further apart do not follow each other
constexpr double kBeyond = 1.3;   // a disc may be so much too large, since walls beside its foot do not count
constexpr double kCentred = 0.8;  // least depth of a chain's place over its disc's radius
constexpr std::size_t kShort = 12;  // places of a line that may echo another
constexpr double kTrue = 0.98;  // least depth of a disc's centre over its radius if no other wall is nearer
constexpr double kSeen =
    1.2 * kUnitsPerMm;             // longest way between places opposite two feet that hides nothing
constexpr double kFirstAsk = 0.4;  // of the furthest: where a wall is looked for first

// The disc that touches the outline in a foot and, opposite, a wall or corner that faces it.
struct Disc {
  double radius = 0;
  double order = 0;  // of the place opposite, as a foot's
  bool sampled = false;
};

class Discs {
 public:
  void take(std::span<const Wall> walls) {
    walls_ = walls, guess_ = 0;
    if (few()) {
      few_.take(walls);
      return;
    }
    tree_.resize(walls.size());
    for (std::size_t i = 0; i < walls.size(); ++i) {
      const Point from = to_point(walls[i].from), to = to_point(walls[i].to);
      tree_.set(i, std::min(from.x, to.x), std::min(from.y, to.y), std::max(from.x, to.x),
                std::max(from.y, to.y));
    }
    tree_.build();
  }

  // @return false if nothing faces the foot within `limit`, or something does within `least`
  bool find(const Foot& foot, double least, double limit, Disc& disc) {
    disc.radius = limit;
    if (few()) return find_among_few(foot, least, disc);
    std::size_t wall = walls_.size();
    bool at_corner = false;
    const auto offer = [&](std::size_t i) {
      bool corner;
      const double radius = radius_to(foot, i, disc.radius, corner);
      if (radius >= disc.radius) return false;
      disc.radius = radius, wall = i, at_corner = corner;
      return radius < least || least <= 0;
    };
    const auto ask = [&](double reach) {
      const Vec centre = foot.at + reach * foot.normal;
      return tree_.any_touching(box_about(centre.x, centre.y, reach),
                                [&](std::size_t i) { return offer(i) && disc.radius < least; });
    };
    each_guess(offer);
    bool shallow = disc.radius < least;
    const bool guessed = disc.radius < limit;
    if (!shallow && !guessed) shallow = ask(kFirstAsk * limit);
    if (!shallow && (guessed || disc.radius > kFirstAsk * limit)) shallow = ask(disc.radius);
    if (wall == walls_.size()) return false;
    guess_ = wall;
    if (shallow) return false;
    touch(foot, wall, at_corner, disc);
    return true;
  }

  // Distance of the nearest wall, or the limit.
  double depth(Vec place, double limit) const {
    if (few()) return std::min(limit, std::sqrt(few_.square_depth(place)));
    double best = limit * limit;
    each_near(place, limit, [&](std::size_t i) {
      const Wall& w = walls_[i];
      const Vec off = place - w.from, way = w.to - w.from;
      const double along = dot(off, way), square = dot(way, way);
      const Vec to_end = place - w.to;
      const double height = dot(off, w.normal);
      best = std::min(best, along <= 0        ? dot(off, off)
                            : along >= square ? dot(to_end, to_end)
                                              : height * height);
    });
    return std::sqrt(best);
  }

 private:
  bool few() const { return walls_.size() <= FewWalls::kMost; }

  bool find_among_few(const Foot& foot, double least, Disc& disc) {
    bool at_corner = false;
    if (least > 0 && radius_to(foot, guess_, least, at_corner) < least) return false;
    const std::size_t wall = few_.opposite(foot, kFacing, disc.radius);
    if (wall == walls_.size()) return false;
    guess_ = wall;
    const double limit = disc.radius;
    disc.radius = radius_to(foot, wall, limit, at_corner);
    if (disc.radius < least || disc.radius >= limit) return false;
    touch(foot, wall, at_corner, disc);
    return true;
  }

  void touch(const Foot& foot, std::size_t wall, bool at_corner, Disc& disc) const {
    const Wall& w = walls_[wall];
    const Vec centre = foot.at + disc.radius * foot.normal;
    disc.sampled = w.sampled;
    disc.order = w.begin + (at_corner ? 0.0 : dot(centre - w.from, w.to - w.from) / w.length);
  }

  // Radius of the disc that touches the outline in the foot and wall i or the corner where it begins, if they
  // face the foot and it is smaller than `limit`.
  double radius_to(const Foot& foot, std::size_t i, double limit, bool& at_corner) const {
    const Wall& w = walls_[i];
    const Vec off = w.from - foot.at;
    const double ahead = dot(off, foot.normal), square = dot(off, off);
    double best = limit;
    if (square < 2 * best * ahead && square * (1 - kFacing) <= 2 * ahead * ahead)
      best = square / (2 * ahead), at_corner = true;
    const double height = -dot(off, w.normal), opening = 1 - dot(foot.normal, w.normal);
    if (opening < 1 - kFacing || height < 0 || height >= best * opening) return best;
    const double radius = height / opening;
    const Vec centre = foot.at + radius * foot.normal;
    if (dot(centre - w.from, w.to - w.from) < 0 || dot(centre - w.to, w.to - w.from) > 0) return best;
    at_corner = false;
    return radius;
  }

  // Walls run side by side: what stood opposite the last foot is a guess. @return whether one satisfied f
  template <class F>
  bool each_guess(F&& f) const {
    const std::size_t n = walls_.size();
    for (std::size_t tried = 0; tried < std::min<std::size_t>(n, 5); ++tried) {
      const std::size_t off = (tried + 1) / 2, i = tried % 2 ? guess_ + off : guess_ + n - off;
      if (f(i < n ? i : i - n)) return true;
    }
    return false;
  }

  template <class F>
  void each_near(Vec place, double reach, F&& f) const {
    tree_.touching(box_about(place.x, place.y, reach), f);
  }

  std::span<const Wall> walls_;
  BoxSearch tree_;
  FewWalls few_;
  std::size_t guess_ = 0;
};

// Leaves out of the chain's beginning what sticks out of a disc further on by less than the least radius:
// arms that run into corners.
template <class Place>
std::size_t arm(Place first, std::size_t size, double narrowest) {
  std::size_t end = 0;
  for (std::size_t j = 1; j < size; ++j)
    if (length(first[0].at - first[std::ptrdiff_t(j)].at) + first[0].radius -
            first[std::ptrdiff_t(j)].radius <=
        narrowest)
      end = j;
    else
      break;
  return end;
}

void drop_arms(std::vector<MedialPlace>& chain, double narrowest) {
  chain.erase(chain.begin(), chain.begin() + std::ptrdiff_t(arm(chain.begin(), chain.size(), narrowest)));
  chain.resize(chain.size() - arm(chain.rbegin(), chain.size(), narrowest));
}

// A place that may stay uncovered.
struct Spot {
  MedialPlace place;
  Vec normal;   // across the axis
  bool judged;  // whether radius and clearance are known
};

// The discs of all lines, to ask what they leave.
class Laid {
 public:
  void take(std::span<const std::vector<MedialPlace>> lines, double narrowest) {
    narrowest_ = narrowest, last_ = 0;
    discs_.clear();
    later_.clear();
    for (std::size_t l = 0; l < lines.size(); ++l)
      for (const MedialPlace& p : lines[l]) discs_.push_back({p, l, lines[l].size()});
    tree_.resize(discs_.size());
    for (std::size_t i = 0; i < discs_.size(); ++i) {
      const MedialPlace& p = discs_[i].place;
      tree_.set(i, box_about(p.at.x, p.at.y, p.radius + narrowest_));
    }
    tree_.build();
    gone_.assign(lines.size(), false);
  }

  // Does a longer line leave a spot of the least radius about this place of a line?
  bool is_own(const MedialPlace& place, std::size_t line, std::size_t size) const {
    bool own = true;
    each_over(place, [&](const Disc& d) {
      if (gone_[d.line] || d.line == line || d.size < size || (d.size == size && d.line > line)) return;
      own = own && length(place.at - d.place.at) + place.radius - d.place.radius > narrowest_;
    });
    return own;
  }
  void forget(std::size_t line) { gone_[line] = true; }

  bool is_left(const MedialPlace& spot) {
    const auto covers = [&](const MedialPlace& p) {
      const Vec off = spot.at - p.at;
      const double reach = p.radius + narrowest_;
      return dot(off, off) < reach * reach;
    };
    if (last_ < discs_.size() && !gone_[discs_[last_].line] && covers(discs_[last_].place)) return false;
    const bool covered = tree_.any_touching(box_about(spot.at.x, spot.at.y, 0), [&](std::size_t i) {
      if (gone_[discs_[i].line] || !covers(discs_[i].place)) return false;
      last_ = i;
      return true;
    });
    return !covered && std::none_of(later_.begin(), later_.end(), covers);
  }
  void add(const MedialPlace& p) { later_.push_back(p); }

 private:
  struct Disc {
    MedialPlace place;
    std::size_t line, size;
  };
  template <class F>
  void each_over(const MedialPlace& p, F&& f) const {
    tree_.touching(box_about(p.at.x, p.at.y, 0), [&](std::size_t i) { f(discs_[i]); });
  }
  double narrowest_ = 0;
  std::vector<Disc> discs_;
  std::vector<bool> gone_;
  std::vector<MedialPlace> later_;
  std::size_t last_ = 0;  // disc that covered the last spot
  BoxSearch tree_;
};

// Short lines that say no more than longer ones go.
void drop_echoes(std::vector<std::vector<MedialPlace>>& lines, Laid& laid) {
  for (std::size_t l = 0; l < lines.size(); ++l) {
    if (lines[l].size() > kShort) continue;
    const auto own = [&](const MedialPlace& p) { return laid.is_own(p, l, lines[l].size()); };
    if (std::any_of(lines[l].begin(), lines[l].end(), own)) continue;
    laid.forget(l);
    lines[l].clear();
  }
  std::erase_if(lines, [](const auto& line) { return line.empty(); });
}

}  // namespace

class MiddleLines::Work {
 public:
  std::span<const std::vector<MedialPlace>> find(std::span<const Wall> walls, std::span<const Foot> feet,
                                                 const AxisLimits& limits, AxisField& field) {
    limits_ = limits, field_ = &field;
    discs_.take(walls);
    lines_.clear();
    spots_.clear();
    std::int32_t run = -1;
    for (const Foot& foot : feet) {
      if (foot.run != run) begin_run();
      run = foot.run;
      visit(foot);
    }
    finish(false);
    if (!spots_.empty()) fill_spots();
    return lines_;
  }

 private:
  void visit(const Foot& foot) {
    const double inside = limits_.inside;
    if (is_seen(foot.order)) return;
    Disc disc;
    if (!discs_.find(foot, limits_.covered + limits_.narrowest, kBeyond * (limits_.next + inside) - inside,
                     disc))
      return;
    const Vec at = foot.at + disc.radius * foot.normal;
    // Each line is found from both of its walls: the first one's is taken.
    if (disc.sampled && disc.order < foot.order) {
      spots_.push_back({{at, disc.radius - limits_.covered}, foot.normal, false});
      return;
    }
    const double depth = discs_.depth(at, disc.radius), radius = depth - limits_.covered;
    see(disc, depth);
    const double clear = clearance(at, depth);
    if (clear <= 0) return;
    const bool worth = clear >= limits_.narrowest;
    if (worth) {
      worth_ = true;
      spots_.push_back({{at, radius}, foot.normal, true});
    }
    // A wall beside its foot is much nearer.
    const double edge = inside > 0 ? limits_.covered : 0.0;
    if (depth - edge < kCentred * (disc.radius - edge)) return;
    if (!chain_.empty()) {
      const double step = length(at - chain_.back().at);
      if (step < kNear) return;
      if (step > kFar) {
        finish(worth);
      } else if (turns_back(at)) {
        if (echoes({at, radius})) return;
        finish(worth);
      }
    }
    chain_.push_back({at, radius});
  }

  // What lies opposite between two feet whose discs touch no other wall sees the same places.
  void see(const Disc& disc, double depth) {
    const bool is_true = depth > kTrue * disc.radius;
    if (is_true && last_true_ && disc.order < last_order_ && last_order_ - disc.order < kSeen)
      seen_.push_back({disc.order, last_order_});
    last_true_ = is_true, last_order_ = disc.order;
  }
  bool is_seen(double order) {
    while (!seen_.empty() && seen_.back().to < order) seen_.pop_back();
    return !seen_.empty() && seen_.back().from <= order;
  }

  // Would the chain turn by more than a right angle? Behind the end of an axis feet see it once more from its
  // other wall.
  bool turns_back(Vec at) const {
    const std::size_t n = chain_.size();
    return n > 1 && dot(at - chain_[n - 1].at, chain_[n - 1].at - chain_[n - 2].at) < 0;
  }
  bool echoes(const MedialPlace& place) const {
    const auto covers = [&](const MedialPlace& p) {
      return length(place.at - p.at) + place.radius - p.radius <= limits_.narrowest;
    };
    return std::any_of(chain_.begin(), chain_.end(), covers);
  }

  // Of a place of this depth; < 0: what lies deeper is the next level's, what lies less deep holds no spot.
  double clearance(Vec at, double depth) {
    if (depth > limits_.next + limits_.drawn || depth < limits_.covered + limits_.narrowest) return -1;
    return field_->clearance(at, 2 * limits_.narrowest);
  }

  void begin_run() {
    finish(false);
    seen_.clear();
    last_true_ = false;
  }

  void finish(bool next_is_worth) {
    if (worth_ && !chain_.empty()) drop_arms(chain_, limits_.narrowest);
    if (worth_ && chain_.size() > 1) lines_.push_back(chain_);
    chain_.clear();
    worth_ = next_is_worth;
  }

  // Widest first; what is not judged yet is no wider than it seems.
  void fill_spots() {
    const auto narrower = [](const Spot& a, const Spot& b) { return a.place.radius < b.place.radius; };
    left_.take(lines_, limits_.narrowest);
    drop_echoes(lines_, left_);
    std::erase_if(spots_, [&](const Spot& s) { return !left_.is_left(s.place); });
    std::make_heap(spots_.begin(), spots_.end(), narrower);
    while (!spots_.empty()) {
      std::pop_heap(spots_.begin(), spots_.end(), narrower);
      Spot s = spots_.back();
      spots_.pop_back();
      if (!left_.is_left(s.place)) continue;
      if (!s.judged) {
        const double depth = discs_.depth(s.place.at, s.place.radius + limits_.covered);
        s.place.radius = depth - limits_.covered, s.judged = true;
        if (clearance(s.place.at, depth) < limits_.narrowest || !left_.is_left(s.place)) continue;
        spots_.push_back(s);
        std::push_heap(spots_.begin(), spots_.end(), narrower);
        continue;
      }
      left_.add(s.place);
      const Vec aside = 0.25 * s.place.radius * left_of(s.normal);
      lines_.push_back({{s.place.at - aside, s.place.radius}, {s.place.at + aside, s.place.radius}});
    }
  }

  AxisLimits limits_;
  AxisField* field_ = nullptr;
  Discs discs_;
  Laid left_;
  std::vector<std::vector<MedialPlace>> lines_;
  std::vector<MedialPlace> chain_;
  std::vector<Spot> spots_;
  struct Seen {
    double from, to;  // orders
  };
  std::vector<Seen> seen_;  // the nearest last
  bool last_true_ = false;  // does the last foot's disc touch no other wall?
  double last_order_ = 0;   // and what it touched
  bool worth_ = false;      // would a spot of the least radius stay without the chain?
};

MiddleLines::MiddleLines() : work_(std::make_unique<Work>()) {}
MiddleLines::~MiddleLines() = default;

std::span<const std::vector<MedialPlace>> MiddleLines::operator()(std::span<const Wall> walls,
                                                                  std::span<const Foot> feet,
                                                                  const AxisLimits& limits,
                                                                  AxisField& field) {
  return work_->find(walls, feet, limits, field);
}

}  // namespace firn::slice
