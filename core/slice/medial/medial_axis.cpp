#include "core/slice/medial/medial_axis.h"

#include <algorithm>
#include <limits>

#include "core/geometry/rtree.h"
#include "core/slice/medial/segment_batch.h"

namespace firn::slice {
namespace {

constexpr double kFacing =
    -0.174;  // cosine of 100 degrees: segments whose normals differ by more face each other
constexpr double kNear = 0.1 * geometry::kUnitsPerMm;  // points closer together are one
constexpr double kFar = 2.0 * geometry::kUnitsPerMm;   // points further apart do not belong to one branch
constexpr double kBeyond =
    1.3;  // a disc may exceed the limit by this factor, since segments beside its sample do not count
constexpr double kCentred = 0.8;    // minimum ratio of the depth of a branch point to its disc's radius
constexpr std::size_t kShort = 12;  // maximum number of points of a branch that may repeat another one
constexpr double kTrue =
    0.98;  // minimum ratio of the depth of a centre to its radius if no other segment is nearer
constexpr double kSeen =
    1.2 *
    geometry::kUnitsPerMm;  // maximum arc length between the contacts of two samples that needs no sample
constexpr double kFirstAsk = 0.4;  // share of the limit within which a segment is searched first

// The disc that touches the outline in a sample and, on the opposite side, a segment or corner that faces it.
struct Disc {
  double radius = 0;
  double order = 0;  // arc length of the contact on the opposite side
  bool sampled = false;
};

class Discs {
 public:
  void take(std::span<const BoundarySegment> segments) {
    segments_ = segments;
    guess_ = 0;
    if (few()) {
      batch_.take(segments);
      return;
    }
    tree_.resize(segments.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const geometry::Point from = to_point(segments[i].from), to = to_point(segments[i].to);
      tree_.set(i, std::min(from.x, to.x), std::min(from.y, to.y), std::max(from.x, to.x),
                std::max(from.y, to.y));
    }
    tree_.build();
  }

  // @return false if nothing faces the sample within `limit`, or if something does within `least`
  bool find(const BoundarySample& sample, double least, double limit, Disc& disc) {
    disc.radius = limit;
    if (few()) return find_among_few(sample, least, disc);
    std::size_t segment = segments_.size();
    bool at_corner = false;
    const auto offer = [&](std::size_t i) {
      bool corner;
      const double radius = radius_to(sample, i, disc.radius, corner);
      if (radius >= disc.radius) return false;
      disc.radius = radius;
      segment = i;
      at_corner = corner;
      return radius < least || least <= 0;
    };
    const auto ask = [&](double reach) {
      const geometry::Vec centre = sample.at + reach * sample.normal;
      return tree_.any_touching(geometry::box_about(centre.x, centre.y, reach),
                                [&](std::size_t i) { return offer(i) && disc.radius < least; });
    };
    each_guess(offer);
    bool shallow = disc.radius < least;
    const bool guessed = disc.radius < limit;
    if (!shallow && !guessed) shallow = ask(kFirstAsk * limit);
    if (!shallow && (guessed || disc.radius > kFirstAsk * limit)) shallow = ask(disc.radius);
    if (segment == segments_.size()) return false;
    guess_ = segment;
    if (shallow) return false;
    touch(sample, segment, at_corner, disc);
    return true;
  }

  // Returns the distance of the nearest segment, or the limit.
  double depth(geometry::Vec place, double limit) const {
    if (few()) return std::min(limit, std::sqrt(batch_.square_depth(place)));
    double best = limit * limit;
    each_near(place, limit, [&](std::size_t i) {
      const BoundarySegment& w = segments_[i];
      const geometry::Vec off = place - w.from, way = w.to - w.from;
      const double along = dot(off, way), square = dot(way, way);
      const geometry::Vec to_end = place - w.to;
      const double height = dot(off, w.normal);
      best = std::min(best, along <= 0        ? dot(off, off)
                            : along >= square ? dot(to_end, to_end)
                                              : height * height);
    });
    return std::sqrt(best);
  }

 private:
  bool few() const { return segments_.size() <= SegmentBatch::kMaxSegments; }

  bool find_among_few(const BoundarySample& sample, double least, Disc& disc) {
    bool at_corner = false;
    if (least > 0 && radius_to(sample, guess_, least, at_corner) < least) return false;
    const std::size_t segment = batch_.opposite(sample, kFacing, disc.radius);
    if (segment == segments_.size()) return false;
    guess_ = segment;
    const double limit = disc.radius;
    disc.radius = radius_to(sample, segment, limit, at_corner);
    if (disc.radius < least || disc.radius >= limit) return false;
    touch(sample, segment, at_corner, disc);
    return true;
  }

  void touch(const BoundarySample& sample, std::size_t segment, bool at_corner, Disc& disc) const {
    const BoundarySegment& w = segments_[segment];
    const geometry::Vec centre = sample.at + disc.radius * sample.normal;
    disc.sampled = w.sampled;
    disc.order = w.begin + (at_corner ? 0.0 : dot(centre - w.from, w.to - w.from) / w.length);
  }

  // Returns the radius of the disc that touches the outline in the sample and segment i, or the corner where
  // it begins, if they face the sample and the radius is below `limit`.
  double radius_to(const BoundarySample& sample, std::size_t i, double limit, bool& at_corner) const {
    const BoundarySegment& w = segments_[i];
    const geometry::Vec off = w.from - sample.at;
    const double ahead = dot(off, sample.normal), square = dot(off, off);
    double best = limit;
    if (square < 2 * best * ahead && square * (1 - kFacing) <= 2 * ahead * ahead) {
      best = square / (2 * ahead);
      at_corner = true;
    }
    const double height = -dot(off, w.normal), opening = 1 - dot(sample.normal, w.normal);
    if (opening < 1 - kFacing || height < 0 || height >= best * opening) return best;
    const double radius = height / opening;
    const geometry::Vec centre = sample.at + radius * sample.normal;
    if (dot(centre - w.from, w.to - w.from) < 0 || dot(centre - w.to, w.to - w.from) > 0) return best;
    at_corner = false;
    return radius;
  }

  // Segments run side by side, so those near the last contact are tried first. @return whether one satisfied
  // f
  template <class F>
  bool each_guess(F&& f) const {
    const std::size_t n = segments_.size();
    for (std::size_t tried = 0; tried < std::min<std::size_t>(n, 5); ++tried) {
      const std::size_t off = (tried + 1) / 2, i = tried % 2 ? guess_ + off : guess_ + n - off;
      if (f(i < n ? i : i - n)) return true;
    }
    return false;
  }

  template <class F>
  void each_near(geometry::Vec place, double reach, F&& f) const {
    tree_.touching(geometry::box_about(place.x, place.y, reach), f);
  }

  std::span<const BoundarySegment> segments_;
  geometry::StaticRTree tree_;
  SegmentBatch batch_;
  std::size_t guess_ = 0;
};

// Returns the number of points at the beginning of a branch that protrude from a later disc by less than the
// minimum radius: branches that run into corners.
template <class Place>
std::size_t end_to_trim(Place first, std::size_t size, double narrowest) {
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

void trim_ends(std::vector<MedialPoint>& branch, double narrowest) {
  branch.erase(branch.begin(),
               branch.begin() + std::ptrdiff_t(end_to_trim(branch.begin(), branch.size(), narrowest)));
  branch.resize(branch.size() - end_to_trim(branch.rbegin(), branch.size(), narrowest));
}

// A point that may remain uncovered.
struct Void {
  MedialPoint place;
  geometry::Vec normal;  // across the axis
  bool exact;            // radius and clearance are known
};

// CoveringDiscs finds the voids that the discs of all branches leave uncovered.
class CoveringDiscs {
 public:
  void take(std::span<const std::vector<MedialPoint>> branches, double narrowest) {
    narrowest_ = narrowest;
    last_ = 0;
    discs_.clear();
    later_.clear();
    for (std::size_t l = 0; l < branches.size(); ++l)
      for (const MedialPoint& p : branches[l]) discs_.push_back({p, l, branches[l].size()});
    tree_.resize(discs_.size());
    for (std::size_t i = 0; i < discs_.size(); ++i) {
      const MedialPoint& p = discs_[i].place;
      tree_.set(i, geometry::box_about(p.at.x, p.at.y, p.radius + narrowest_));
    }
    tree_.build();
    gone_.assign(branches.size(), false);
  }

  // Returns whether this point of a branch covers a void of the minimum radius that no longer branch covers.
  bool covers_more(const MedialPoint& place, std::size_t branch, std::size_t size) const {
    bool own = true;
    each_over(place, [&](const Disc& d) {
      if (gone_[d.branch] || d.branch == branch || d.size < size || (d.size == size && d.branch > branch))
        return;
      own = own && length(place.at - d.place.at) + place.radius - d.place.radius > narrowest_;
    });
    return own;
  }
  void forget(std::size_t branch) { gone_[branch] = true; }

  bool leaves_void(const MedialPoint& void_disc) {
    const auto covers = [&](const MedialPoint& p) {
      const geometry::Vec off = void_disc.at - p.at;
      const double reach = p.radius + narrowest_;
      return dot(off, off) < reach * reach;
    };
    if (last_ < discs_.size() && !gone_[discs_[last_].branch] && covers(discs_[last_].place)) return false;
    const bool covered =
        tree_.any_touching(geometry::box_about(void_disc.at.x, void_disc.at.y, 0), [&](std::size_t i) {
          if (gone_[discs_[i].branch] || !covers(discs_[i].place)) return false;
          last_ = i;
          return true;
        });
    return !covered && std::none_of(later_.begin(), later_.end(), covers);
  }
  void add(const MedialPoint& p) { later_.push_back(p); }

 private:
  struct Disc {
    MedialPoint place;
    std::size_t branch, size;
  };
  template <class F>
  void each_over(const MedialPoint& p, F&& f) const {
    tree_.touching(geometry::box_about(p.at.x, p.at.y, 0), [&](std::size_t i) { f(discs_[i]); });
  }
  double narrowest_ = 0;
  std::vector<Disc> discs_;
  std::vector<bool> gone_;
  std::vector<MedialPoint> later_;
  std::size_t last_ = 0;  // disc that covered the last void
  geometry::StaticRTree tree_;
};

// Removes short branches that repeat longer ones.
void drop_duplicates(std::vector<std::vector<MedialPoint>>& branches, CoveringDiscs& covering) {
  for (std::size_t l = 0; l < branches.size(); ++l) {
    if (branches[l].size() > kShort) continue;
    const auto own = [&](const MedialPoint& p) { return covering.covers_more(p, l, branches[l].size()); };
    if (std::any_of(branches[l].begin(), branches[l].end(), own)) continue;
    covering.forget(l);
    branches[l].clear();
  }
  std::erase_if(branches, [](const auto& branch) { return branch.empty(); });
}

}  // namespace

class MedialAxis::Work {
 public:
  std::span<const std::vector<MedialPoint>> find(std::span<const BoundarySegment> segments,
                                                 std::span<const BoundarySample> samples,
                                                 const MedialLimits& limits, ClearanceField& field) {
    limits_ = limits;
    field_ = &field;
    discs_.take(segments);
    branches_.clear();
    voids_.clear();
    std::int32_t run = -1;
    for (const BoundarySample& sample : samples) {
      if (sample.run != run) begin_run();
      run = sample.run;
      visit(sample);
    }
    finish(false);
    if (!voids_.empty()) cover_voids();
    return branches_;
  }

 private:
  void visit(const BoundarySample& sample) {
    const double inside = limits_.inside;
    if (is_seen(sample.order)) return;
    Disc disc;
    if (!discs_.find(sample, limits_.covered + limits_.narrowest, kBeyond * (limits_.next + inside) - inside,
                     disc))
      return;
    const geometry::Vec at = sample.at + disc.radius * sample.normal;
    // Each branch is found from both of its sides; the first one is taken.
    if (disc.sampled && disc.order < sample.order) {
      voids_.push_back({{at, disc.radius - limits_.covered}, sample.normal, false});
      return;
    }
    const double depth = discs_.depth(at, disc.radius), radius = depth - limits_.covered;
    see(disc, depth);
    const double clear = clearance(at, depth);
    if (clear <= 0) return;
    const bool worth = clear >= limits_.narrowest;
    if (worth) {
      worth_ = true;
      voids_.push_back({{at, radius}, sample.normal, true});
    }
    // Segments beside the sample are much nearer.
    const double edge = inside > 0 ? limits_.covered : 0.0;
    if (depth - edge < kCentred * (disc.radius - edge)) return;
    if (!branch_.empty()) {
      const double step = length(at - branch_.back().at);
      if (step < kNear) return;
      if (step > kFar) {
        finish(worth);
      } else if (turns_back(at)) {
        if (repeats({at, radius})) return;
        finish(worth);
      }
    }
    branch_.push_back({at, radius});
  }

  // The contacts between those of two samples whose discs touch no other segment would see the same points.
  void see(const Disc& disc, double depth) {
    const bool is_true = depth > kTrue * disc.radius;
    if (is_true && last_true_ && disc.order < last_order_ && last_order_ - disc.order < kSeen)
      seen_.push_back({disc.order, last_order_});
    last_true_ = is_true;
    last_order_ = disc.order;
  }
  bool is_seen(double order) {
    while (!seen_.empty() && seen_.back().to < order) seen_.pop_back();
    return !seen_.empty() && seen_.back().from <= order;
  }

  // Returns whether the branch would turn by more than a right angle. Behind the end of an axis, samples of
  // the other side see it again.
  bool turns_back(geometry::Vec at) const {
    const std::size_t n = branch_.size();
    return n > 1 && dot(at - branch_[n - 1].at, branch_[n - 1].at - branch_[n - 2].at) < 0;
  }
  bool repeats(const MedialPoint& place) const {
    const auto covers = [&](const MedialPoint& p) {
      return length(place.at - p.at) + place.radius - p.radius <= limits_.narrowest;
    };
    return std::any_of(branch_.begin(), branch_.end(), covers);
  }

  // Returns the clearance of a point of this depth; < 0: deeper points belong to the next level, and less
  // deep ones hold no void.
  double clearance(geometry::Vec at, double depth) {
    if (depth > limits_.next + limits_.drawn || depth < limits_.covered + limits_.narrowest) return -1;
    return field_->clearance(at, 2 * limits_.narrowest);
  }

  void begin_run() {
    finish(false);
    seen_.clear();
    last_true_ = false;
  }

  void finish(bool next_is_worth) {
    if (worth_ && !branch_.empty()) trim_ends(branch_, limits_.narrowest);
    if (worth_ && branch_.size() > 1) branches_.push_back(branch_);
    branch_.clear();
    worth_ = next_is_worth;
  }

  // Covers voids in descending order of their radius; a radius that has not been computed exactly is an upper
  // bound.
  void cover_voids() {
    const auto narrower = [](const Void& a, const Void& b) { return a.place.radius < b.place.radius; };
    covering_.take(branches_, limits_.narrowest);
    drop_duplicates(branches_, covering_);
    std::erase_if(voids_, [&](const Void& s) { return !covering_.leaves_void(s.place); });
    std::make_heap(voids_.begin(), voids_.end(), narrower);
    while (!voids_.empty()) {
      std::pop_heap(voids_.begin(), voids_.end(), narrower);
      Void s = voids_.back();
      voids_.pop_back();
      if (!covering_.leaves_void(s.place)) continue;
      if (!s.exact) {
        const double depth = discs_.depth(s.place.at, s.place.radius + limits_.covered);
        s.place.radius = depth - limits_.covered;
        s.exact = true;
        if (clearance(s.place.at, depth) < limits_.narrowest || !covering_.leaves_void(s.place)) continue;
        voids_.push_back(s);
        std::push_heap(voids_.begin(), voids_.end(), narrower);
        continue;
      }
      covering_.add(s.place);
      const geometry::Vec aside = 0.25 * s.place.radius * left_of(s.normal);
      branches_.push_back({{s.place.at - aside, s.place.radius}, {s.place.at + aside, s.place.radius}});
    }
  }

  MedialLimits limits_;
  ClearanceField* field_ = nullptr;
  Discs discs_;
  CoveringDiscs covering_;
  std::vector<std::vector<MedialPoint>> branches_;
  std::vector<MedialPoint> branch_;
  std::vector<Void> voids_;
  struct Seen {
    double from, to;  // arc lengths
  };
  std::vector<Seen> seen_;  // in descending order
  bool last_true_ = false;  // the disc of the last sample touches no other segment
  double last_order_ = 0;   // arc length of its contact
  bool worth_ = false;      // a void of the minimum radius would remain without the branch
};

MedialAxis::MedialAxis() : work_(std::make_unique<Work>()) {}
MedialAxis::~MedialAxis() = default;

std::span<const std::vector<MedialPoint>> MedialAxis::operator()(std::span<const BoundarySegment> segments,
                                                                 std::span<const BoundarySample> samples,
                                                                 const MedialLimits& limits,
                                                                 ClearanceField& field) {
  return work_->find(segments, samples, limits, field);
}

}  // namespace firn::slice
