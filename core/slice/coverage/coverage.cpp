#include "core/slice/coverage/coverage.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/box.h"
#include "core/geometry/vec.h"
#include "core/slice/offset/offset_rings.h"

namespace firn::slice {
namespace {

constexpr double kMaxCuts = 8e6;

struct Interval {
  double from, to;
};

// Computes the part of the scan line at height y (units) within `half` of the segment a-b. The set is convex,
// hence one interval.
bool interval_of_line(geometry::Vec a, geometry::Vec b, double half, double y, Interval& s) {
  double from = 1e300, to = -1e300;
  const auto disc = [&](geometry::Vec c) {
    const double square = half * half - (y - c.y) * (y - c.y);
    if (square <= 0) return;
    const double root = std::sqrt(square);
    from = std::min(from, c.x - root);
    to = std::max(to, c.x + root);
  };
  disc(a);
  disc(b);
  const double l = length(b - a);
  if (l > 0) {
    const geometry::Vec side = (half / l) * left_of(b - a);
    const geometry::Vec corners[4] = {a + side, b + side, b - side, a - side};
    for (int i = 0; i < 4; ++i) {
      const geometry::Vec p = corners[i], q = corners[(i + 1) % 4];
      if ((p.y <= y) == (q.y <= y)) continue;
      const double x = p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x);
      from = std::min(from, x);
      to = std::max(to, x);
    }
  }
  s = {from, to};
  return to > from;
}

struct Event {
  double x;
  std::int32_t wanted, extrusions;  // changes
};

// Scan lines of one material.
class Scan {
 public:
  Scan(double low, double high, double pitch)
      : low_(low), pitch_(pitch), rows_(std::size_t(std::max(1.0, std::ceil((high - low) / pitch)))) {}

  void add_edge(geometry::Vec a, geometry::Vec b) {
    const std::int32_t change =
        b.y < a.y ? 1 : -1;  // material lies left of an edge, so it begins at a falling one
    each_row(std::min(a.y, b.y), std::max(a.y, b.y), [&](std::vector<Event>& row, double y) {
      if ((a.y <= y) != (b.y <= y)) row.push_back({a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x), change, 0});
    });
  }
  void add_line(geometry::Vec a, geometry::Vec b, double half) {
    touched_from_ = std::min(touched_from_, row_of(std::min(a.y, b.y) - half));
    touched_to_ = std::max(touched_to_, row_of(std::max(a.y, b.y) + half) + 1);
    each_row(std::min(a.y, b.y) - half, std::max(a.y, b.y) + half, [&](std::vector<Event>& row, double y) {
      Interval s;
      if (!interval_of_line(a, b, half, y, s)) return;
      row.push_back({s.from, 0, 1});
      row.push_back({s.to, 0, -1});
    });
  }

  // Neighbouring segments of one path share their round ends: a path counts once wherever it lies.
  void finish_path() {
    done_.resize(rows_.size(), 0);
    for (std::size_t r = touched_from_; r < std::min(touched_to_, rows_.size()); ++r) {
      std::vector<Event>& row = rows_[r];
      const std::size_t begin = done_[r];
      const auto first = row.begin() + std::ptrdiff_t(begin);
      if (row.size() > begin) {
        std::sort(first, row.end(), [](const Event& a, const Event& b) { return a.x < b.x; });
        std::vector<Event> merged;
        int depth = 0;
        for (auto e = first; e != row.end(); ++e) {
          const int before = depth;
          depth += e->extrusions;
          if ((before == 0) != (depth == 0)) merged.push_back({e->x, 0, depth ? 1 : -1});
        }
        row.resize(begin);
        row.insert(row.end(), merged.begin(), merged.end());
      }
      done_[r] = row.size();
    }
    touched_from_ = rows_.size();
    touched_to_ = 0;
  }

  Coverage sum() {
    Coverage c;
    std::vector<std::vector<Interval>> gaps(rows_.size());
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      std::vector<Event>& row = rows_[r];
      std::sort(row.begin(), row.end(), [](const Event& a, const Event& b) { return a.x < b.x; });
      int wanted = 0, extrusions = 0;
      for (std::size_t i = 0; i + 1 < row.size(); ++i) {
        wanted += row[i].wanted;
        extrusions += row[i].extrusions;
        const double area = (row[i + 1].x - row[i].x) * pitch_ * geometry::kMmPerUnit * geometry::kMmPerUnit;
        if (wanted > 0) c.wanted_mm2 += area;
        if (extrusions > 0) c.swept_mm2 += area;
        if (extrusions > 1) c.overlap_mm2 += (extrusions - 1) * area;
        if (extrusions > 0 && wanted <= 0) c.beyond_mm2 += area;
        if (wanted > 0 && extrusions <= 0) {
          c.gap_mm2 += area;
          if (!gaps[r].empty() && gaps[r].back().to == row[i].x)
            gaps[r].back().to = row[i + 1].x;
          else if (row[i + 1].x > row[i].x)
            gaps[r].push_back({row[i].x, row[i + 1].x});
        }
      }
    }
    c.widest_gap_mm = widest(gaps);
    return c;
  }

 private:
  // Returns the first row at or above y.
  std::size_t row_of(double y) const {
    return std::size_t(std::max(0.0, std::ceil((y - low_) / pitch_ - 0.5)));
  }

  template <class F>
  void each_row(double from, double to, F&& f) {
    for (std::size_t r = row_of(from); r < rows_.size(); ++r) {
      const double y = low_ + (double(r) + 0.5) * pitch_;
      if (y > to) break;
      f(rows_[r], y);
    }
  }

  // Returns the diameter of the largest circle in the gaps whose centre is on a scan line, found by growing
  // circles along each gap interval.
  double widest(const std::vector<std::vector<Interval>>& gaps) const {
    const auto inside = [&](std::ptrdiff_t r, double from, double to) {
      if (r < 0 || r >= std::ptrdiff_t(gaps.size())) return false;
      const std::vector<Interval>& row = gaps[std::size_t(r)];
      const auto behind = std::upper_bound(row.begin(), row.end(), from,
                                           [](double x, const Interval& s) { return x < s.from; });
      return behind != row.begin() && to <= std::prev(behind)->to;
    };
    double best = 0;
    for (std::size_t r = 0; r < gaps.size(); ++r) {
      for (const Interval& s : gaps[r]) {
        // Tries circles of the best radius so far, slightly enlarged, along the interval.
        for (double x = s.from + best; x <= s.to - best; x += pitch_) {
          for (;;) {
            const double radius = best + 0.25 * pitch_;
            bool fits = true;
            for (std::ptrdiff_t k = 0; fits && double(k) * pitch_ <= radius; ++k) {
              const double half = std::sqrt(std::max(0.0, radius * radius - double(k * k) * pitch_ * pitch_));
              fits = inside(std::ptrdiff_t(r) + k, x - half, x + half) &&
                     inside(std::ptrdiff_t(r) - k, x - half, x + half);
            }
            if (!fits) break;
            best = radius;
          }
        }
      }
    }
    return 2 * best * geometry::kMmPerUnit;
  }

  double low_, pitch_;
  std::vector<std::vector<Event>> rows_;
  std::vector<std::size_t> done_;
  std::size_t touched_from_ = rows_.size(), touched_to_ = 0;  // rows of the path in progress
};

// The hook wall is ice in the place of scaffold: it fills the area of the scaffold and not that of the part.
bool fills(const PathInfo& info, std::size_t material) {
  if (info.kind == PathKind::kMeasurement) return false;
  return info.kind == PathKind::kHook ? material == kScaffoldMaterial : info.material == material;
}

// Returns a pitch at which scan lines intersect extrusion lines no more often than kMaxCuts.
double pitch_for(const LayerPaths& paths, std::size_t material, double asked) {
  double height = 0;
  for (std::size_t i = 0; i < paths.info.size(); ++i) {
    if (!fills(paths.info[i], material)) continue;
    const auto line = paths.lines[i];
    for (std::size_t p = paths.info[i].closed ? 0 : 1; p < line.size(); ++p)
      height += std::abs(double(line[p].y) - line[p ? p - 1 : line.size() - 1].y) + paths.info[i].width;
  }
  return std::max(asked, 2 * height / kMaxCuts);
}

}  // namespace

std::vector<Coverage> coverage(const LayerRegions& regions, const LayerPaths& paths,
                               const PathOptions& options, double pitch_mm) {
  std::vector<Coverage> result;
  for (std::size_t m = 0; m < regions.by_material.size(); ++m) {
    const ExtrusionOptions& extrusion = m == kScaffoldMaterial ? options.scaffold : options.part;
    const double inset_mm = extrusion.first_offset_mm - 0.5 * extrusion.boundary_width_mm;
    geometry::Region wanted = regions.by_material[m];
    if (inset_mm < 0) {
      wanted = grow(wanted, -inset_mm, 0);
    } else if (inset_mm > 0) {
      const RingLevels inside =
          offset_rings(wanted, {.first_mm = inset_mm, .boundaries = 0, .max_rings = 1}, 0);
      wanted = inside.levels.empty() ? geometry::Region{} : inside.levels[0];
    }
    geometry::BoxOf<double> box;
    for (const geometry::Point p : wanted.points) box.add(p.x, p.y);
    for (std::size_t i = 0; i < paths.info.size(); ++i) {
      const double half = 0.5 * paths.info[i].width;
      if (!fills(paths.info[i], m)) continue;
      for (const geometry::Point p : paths.lines[i]) {
        box.add(p.x - half, p.y - half);
        box.add(p.x + half, p.y + half);
      }
    }
    if (box.x1 < box.x0) {
      result.push_back({});
      continue;
    }
    const double pitch = pitch_for(paths, m, pitch_mm * geometry::kUnitsPerMm);
    Scan scan(box.y0, box.y1, pitch);
    for (std::size_t i = 0; i < paths.info.size(); ++i) {
      const PathInfo& info = paths.info[i];
      if (!fills(info, m)) continue;
      const auto line = paths.lines[i];
      for (std::size_t p = info.closed ? 0 : 1; p < line.size(); ++p)
        scan.add_line(to_vec(line[p ? p - 1 : line.size() - 1]), to_vec(line[p]), 0.5 * info.width);
      scan.finish_path();
    }
    for (std::size_t r = 0; r < wanted.size(); ++r)
      for (std::size_t p = 0; p < wanted[r].size(); ++p)
        scan.add_edge(to_vec(wanted[r][p]), to_vec(wanted[r][p + 1 < wanted[r].size() ? p + 1 : 0]));
    result.push_back(scan.sum());
    result.back().pitch_mm = pitch * geometry::kMmPerUnit;
  }
  return result;
}

}  // namespace firn::slice
