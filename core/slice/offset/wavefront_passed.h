// Has the front passed a place?
#pragma once

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include "core/slice/offset/wavefront.h"

namespace firn::slice::wavefront {

inline double square_distance(Vec place, const Source& source) {
  Vec away = place - source.at;
  if (!source.corner()) away = away - std::clamp(dot(away, source.along), 0.0, source.length) * source.along;
  return dot(away, away);
}

/// Looks for sources near places: in the boxes of blocks of those that follow each other along the outline,
/// and of blocks of blocks. Keeps its working memory.
class PassedBy {
 public:
  void begin(std::span<const Source> sources) {
    sources_ = sources;
    blocks_.clear();
  }
  /// Is any of them nearer to the place than `distance`?
  bool operator()(Vec place, double distance) {
    if (blocks_.empty()) list();
    const double square = distance * distance;
    for (std::size_t high = 0; high < high_.size(); ++high) {
      if (high_[high].square_distance(place) >= square) continue;
      const std::size_t end = std::min(blocks_.size(), (high + 1) * kBlock);
      for (std::size_t b = high * kBlock; b < end; ++b)
        if (blocks_[b].square_distance(place) < square && near(b, place, square)) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kBlock = 16;
  struct Box {
    double x0 = std::numeric_limits<double>::max(), y0 = x0, x1 = -x0, y1 = -x0;
    void add(const Box& o) {
      x0 = std::min(x0, o.x0), y0 = std::min(y0, o.y0);
      x1 = std::max(x1, o.x1), y1 = std::max(y1, o.y1);
    }
    double square_distance(Vec p) const {
      const double x = std::max(std::max(x0 - p.x, p.x - x1), 0.0),
                   y = std::max(std::max(y0 - p.y, p.y - y1), 0.0);
      return x * x + y * y;
    }
  };
  void list() {
    high_.clear();
    for (std::size_t first = 0; first < sources_.size(); first += kBlock) {
      Box box;
      for (std::size_t i = first; i < std::min(sources_.size(), first + kBlock); ++i) {
        const Source& s = sources_[i];
        const Vec end = s.at + std::max(s.length, 0.0) * s.along;  // a corner's length is below 0
        box.add({std::min(s.at.x, end.x), std::min(s.at.y, end.y), std::max(s.at.x, end.x),
                 std::max(s.at.y, end.y)});
      }
      if (blocks_.size() % kBlock == 0) high_.emplace_back();
      high_.back().add(box);
      blocks_.push_back(box);
    }
  }
  bool near(std::size_t block, Vec place, double square) const {
    const std::size_t first = block * kBlock;
    const std::span<const Source> sources =
        sources_.subspan(first, std::min(kBlock, sources_.size() - first));
    return std::any_of(sources.begin(), sources.end(),
                       [&](const Source& s) { return wavefront::square_distance(place, s) < square; });
  }

  std::span<const Source> sources_;
  std::vector<Box> blocks_, high_;
};

}  // namespace firn::slice::wavefront
