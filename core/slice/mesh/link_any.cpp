// Links layers of irregular meshes: branching edges, inconsistently wound facets, borders.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/geometry/planar.h"
#include "core/geometry/point_measures.h"
#include "core/geometry/rings.h"
#include "core/slice/mesh/link_layer.h"

namespace firn::slice {
namespace {

constexpr std::uint32_t kNone = ~0u;
constexpr double kTinyGap =
    100.0;  // units; gaps up to 0.01 mm are due to rounding (T-junctions) and reported as one

// Each segment has two ends: 2 s is its first point, 2 s + 1 its last one.
bool begins(std::uint32_t end) { return (end & 1) == 0; }
std::uint32_t other(std::uint32_t end) { return end ^ 1; }

class Linker {
 public:
  Linker(const std::vector<Segment>& segments, std::int32_t layer)
      : segments_(segments), layer_(layer), mate_(2 * segments.size(), kNone) {}

  Contours run(const SliceOptions& options) {
    join_on_edges();
    join_near(options.closing_gap_mm * geometry::kUnitsPerMm);
    close_on_itself(options.closing_share);
    drop_open();
    trace();
    report();
    return std::move(out_);
  }

 private:
  const geometry::Point& point(std::uint32_t end) const {
    return begins(end) ? segments_[end / 2].from : segments_[end / 2].to;
  }
  std::uint32_t edge(std::uint32_t end) const {
    return begins(end) ? segments_[end / 2].from_edge : segments_[end / 2].to_edge;
  }
  void mate(std::uint32_t a, std::uint32_t b) {
    mate_[a] = b;
    mate_[b] = a;
  }

  // Joins the last point of a segment with the first point of another one, then the remaining ends of one
  // kind in pairs. Any pairing at one point of one edge has the same winding numbers.
  void join_on_edges() {
    std::vector<std::uint32_t> ends(mate_.size());
    for (std::uint32_t e = 0; e < ends.size(); ++e) ends[e] = e;
    join_equal(
        ends, [&](std::uint32_t e) { return std::tuple(edge(e), point(e)); },
        [&](std::size_t met, const geometry::Point& at) {
          if (met > 2) count(branching_, at);
        });
  }

  template <class Key, class Met>
  void join_equal(std::vector<std::uint32_t>& ends, const Key& key, const Met& met) {
    const auto full_key = [&](std::uint32_t e) { return std::tuple(key(e), !begins(e), e); };
    std::sort(ends.begin(), ends.end(),
              [&](std::uint32_t a, std::uint32_t b) { return full_key(a) < full_key(b); });
    for (std::size_t i = 0; i < ends.size();) {
      std::size_t j = i, middle = i;
      for (; j < ends.size() && key(ends[j]) == key(ends[i]); ++j)
        if (begins(ends[j])) middle = j + 1;
      std::size_t b = i, e = middle;
      while (b < middle && e < j) mate(ends[b++], ends[e++]);
      for (; b + 1 < middle; b += 2) mate(ends[b], ends[b + 1]);
      for (; e + 1 < j; e += 2) mate(ends[e], ends[e + 1]);
      met(j - i, point(ends[i]));
      i = j;
    }
  }

  struct Chain {
    std::uint32_t begin, end;
    double length;
  };

  // Follows each end without a mate to the other end of its chain; chains of a single point are left out.
  std::vector<Chain> open_chains() const {
    std::vector<Chain> chains;
    std::vector<bool> seen(mate_.size());
    for (std::uint32_t e = 0; e < mate_.size(); ++e) {
      if (mate_[e] != kNone || seen[e]) continue;
      Chain chain{e, e, 0.0};
      for (std::uint32_t at = e;; at = mate_[chain.end]) {
        if (at != e) chain.length += distance(point(chain.end), point(at));
        chain.end = other(at);
        chain.length += distance(point(at), point(chain.end));
        if (mate_[chain.end] == kNone) break;
      }
      seen[chain.end] = true;
      if (chain.length > 0.0) chains.push_back(chain);
    }
    return chains;
  }

  // Joins the nearest ends first, in rounds of growing reach: after each round the remaining ends are further
  // apart than its reach.
  void join_near(double closing_gap) {
    std::vector<std::uint32_t> open;
    for (const Chain& chain : open_chains()) open.insert(open.end(), {chain.begin, chain.end});
    join_equal(
        open, [&](std::uint32_t e) { return point(e); }, [](std::size_t, const geometry::Point&) {});
    std::erase_if(open, [&](std::uint32_t e) { return mate_[e] != kNone; });
    struct Gap {
      double length;
      bool against;
      std::uint32_t a, b;
    };
    std::vector<Gap> gaps;
    for (double reach = std::min(4.0, closing_gap); !open.empty();) {
      std::sort(open.begin(), open.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(point(a), a) < std::tuple(point(b), b);
      });
      gaps.clear();
      for (std::size_t i = 0; i < open.size(); ++i)
        for (std::size_t j = i + 1; j < open.size() && double(point(open[j]).x) - point(open[i]).x <= reach;
             ++j) {
          const double d = distance(point(open[i]), point(open[j]));
          if (d <= reach) gaps.push_back({d, begins(open[i]) == begins(open[j]), open[i], open[j]});
        }
      const auto key = [&](const Gap& g) {
        return std::tuple(g.length, g.against, point(g.a), point(g.b), g.a, g.b);
      };
      std::sort(gaps.begin(), gaps.end(), [&](const Gap& a, const Gap& b) { return key(a) < key(b); });
      for (const Gap& g : gaps)
        if (mate_[g.a] == kNone && mate_[g.b] == kNone) {
          mate(g.a, g.b);
          report_gap(g.length, std::min(point(g.a), point(g.b)));
        }
      std::erase_if(open, [&](std::uint32_t e) { return mate_[e] != kNone; });
      if (reach >= closing_gap) break;
      reach = std::min(4.0 * reach, closing_gap);
    }
  }

  // Closes chains that are nearly complete on themselves: a hole in the mesh must not remove the whole
  // contour.
  void close_on_itself(double share) {
    for (const Chain& chain : open_chains()) {
      const double gap = distance(point(chain.begin), point(chain.end));
      if (gap > share * chain.length) continue;
      mate(chain.begin, chain.end);
      report_gap(gap, std::min(point(chain.begin), point(chain.end)));
    }
  }

  void report_gap(double length, const geometry::Point& at) {
    if (length > kTinyGap) {
      out_.defects.push_back({DefectKind::kGapClosed, layer_, at, length * geometry::kMmPerUnit, 1});
    } else if (length > 0.0) {
      count(tiny_gaps_, at);
      tiny_gaps_.size_mm = std::max(tiny_gaps_.size_mm, length * geometry::kMmPerUnit);
    }
  }

  void drop_open() {
    done_.assign(segments_.size(), false);
    for (const Chain& chain : open_chains())
      out_.defects.push_back({DefectKind::kOpenDropped, layer_,
                              std::min(point(chain.begin), point(chain.end)),
                              chain.length * geometry::kMmPerUnit, 1});
    for (std::uint32_t e = 0; e < mate_.size(); ++e)
      for (std::uint32_t at = e; mate_[e] == kNone && !done_[at / 2]; at = mate_[other(at)]) {
        done_[at / 2] = true;
        if (mate_[other(at)] == kNone) break;
      }
  }

  // The remaining chains are closed. A chain takes the direction of the greater length of its segments.
  void trace() {
    std::vector<geometry::Point> ring;
    for (std::uint32_t first = 0; first < segments_.size(); ++first) {
      if (done_[first]) continue;
      ring.clear();
      std::int64_t along = 0, against = 0;
      for (std::uint32_t entry = 2 * first; !done_[entry / 2]; entry = mate_[other(entry)]) {
        done_[entry / 2] = true;
        const geometry::Point &p = point(entry), &q = point(other(entry));
        ring.push_back(p);
        ring.push_back(q);
        (begins(entry) ? along : against) +=
            std::abs(std::int64_t(q.x) - p.x) + std::abs(std::int64_t(q.y) - p.y);
      }
      if (along > 0 && against > 0) count(turned_, *std::min_element(ring.begin(), ring.end()));
      if (against > along || (against == along && twice_area(ring) < 0))
        std::reverse(ring.begin(), ring.end());
      append_canonical(ring, out_.rings);
    }
    out_.rings = sorted(std::move(out_.rings));
  }

  void count(Defect& defect, const geometry::Point& at) {
    defect.at = defect.count ? std::min(defect.at, at) : at;
    ++defect.count;
  }

  void report() {
    for (const Defect& d : {branching_, turned_, tiny_gaps_})
      if (d.count) out_.defects.push_back(d);
    std::sort(out_.defects.begin(), out_.defects.end(), [](const Defect& a, const Defect& b) {
      return std::tuple(a.kind, a.at, a.size_mm) < std::tuple(b.kind, b.at, b.size_mm);
    });
  }

  const std::vector<Segment>& segments_;
  std::int32_t layer_;
  std::vector<std::uint32_t> mate_;
  std::vector<bool> done_;
  Contours out_;
  Defect branching_{DefectKind::kBranching, layer_, {}, 0.0, 0};
  Defect turned_{DefectKind::kTurned, layer_, {}, 0.0, 0};
  Defect tiny_gaps_{DefectKind::kGapClosed, layer_, {}, 0.0, 0};
};

}  // namespace

Contours link_any(std::vector<Segment>& segments, const SliceOptions& options, std::int32_t layer) {
  std::sort(segments.begin(), segments.end());
  return Linker(segments, layer).run(options);
}

}  // namespace firn::slice
