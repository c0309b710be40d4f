// Local deaths: a piece that shrinks to nothing leaves the front, in the order of the distances at which it happens.
#include <algorithm>
#include <queue>

#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {
namespace {

constexpr double kClose = 0.01;  // units: distances of death are searched to this

struct Death {
  double d;
  std::int32_t piece;
  std::uint32_t stamp;
  bool operator>(const Death& o) const { return d != o.d ? d > o.d : piece > o.piece; }
};

// One loop as a doubly linked list over its pieces.
class Loop {
 public:
  Loop(std::span<const Source> sources, std::span<Piece> pieces, double to)
      : sources_(sources), pieces_(pieces), to_(to), links_(pieces.size()) {
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      links_[i].prev = std::int32_t(i ? i - 1 : pieces.size() - 1);
      links_[i].next = std::int32_t(i + 1 < pieces.size() ? i + 1 : 0);
    }
    alive_ = std::int32_t(pieces.size());
  }

  // Extent of a piece along its source; it falls as d grows.
  double extent(std::int32_t i, double d) const {
    return dot(pieces_[links_[i].next].start(d) - pieces_[i].start(d), sources_[pieces_[i].source].along);
  }

  void expect_death(std::int32_t i, double since) {
    ++links_[i].stamp;
    if (pieces_[i].source == kPivot) return;
    const double end = dot(pieces_[links_[i].next].from - pieces_[i].from, sources_[pieces_[i].source].along);
    if (end >= 0) return;
    deaths_.push({death(i, since, end), i, links_[i].stamp});
  }

  bool run() {
    while (!deaths_.empty() && alive_ > 1) {
      const Death next = deaths_.top();
      deaths_.pop();
      if (links_[next.piece].stamp == next.stamp) die(next.piece, next.d);
    }
    return alive_ > 1;
  }

  // The loop's pieces in order, appended.
  void collect(std::vector<Piece>& out) const {
    std::int32_t first = 0;
    while (links_[first].next < 0) ++first;
    for (std::int32_t i = first;;) {
      out.push_back(pieces_[i]);
      i = links_[i].next;
      if (i == first) break;
    }
  }

 private:
  double death(std::int32_t i, double since, double end) const {
    double low = since, high = to_, at_low = extent(i, low), at_high = end;
    if (at_low <= 0) return low;
    const bool straight = pieces_[i].start.kind == Junction::Kind::kStraight &&
                          pieces_[links_[i].next].start.kind == Junction::Kind::kStraight;
    // Regula falsi, Illinois variant.
    for (int step = 0; step < 40 && high - low > kClose; ++step) {
      const double middle = low + (high - low) * at_low / (at_low - at_high);
      if (straight) return middle;
      const double value = extent(i, middle);
      if (std::abs(value) < 1e-3) return middle;
      if (value > 0) {
        low = middle, at_low = value;
        at_high *= 0.5;
      } else {
        high = middle, at_high = value;
        at_low *= 0.5;
      }
    }
    return 0.5 * (low + high);
  }

  // Junction of a piece with a fixed place, which it sees along its own normal.
  Junction radial(std::int32_t i, Vec place) const {
    const Source& source = sources_[pieces_[i].source];
    const Vec away = place - source.at;
    if (!source.corner())
      return {Junction::Kind::kStraight, source.at + dot(away, source.along) * source.along, left_of(source.along), {}, 0};
    const double l = length(away);
    return {Junction::Kind::kStraight, source.at, l > 0 ? (1 / l) * away : left_of(source.along), {}, 0};
  }

  void die(std::int32_t i, double d) {
    const std::int32_t a = links_[i].prev, c = links_[i].next;
    const Vec place = 0.5 * (pieces_[i].start(d) + pieces_[c].start(d));
    const bool pivots = pieces_[a].source == kPivot || pieces_[c].source == kPivot;
    Junction junction;
    ++links_[i].stamp;
    --alive_;
    if (a != c && !pivots && meet(sources_[pieces_[a].source], sources_[pieces_[c].source], place, d, junction)) {
      links_[a].next = c;
      links_[c].prev = a;
      links_[i].next = -1;
      pieces_[c].start = junction;
      pieces_[c].from = junction(to_);
    } else {
      pieces_[i].source = kPivot;
      if (pieces_[a].source != kPivot) pieces_[i].start = radial(a, place);
      else pieces_[i].start = {Junction::Kind::kStraight, pieces_[a].start.normal, {}, {}, 0};
      pieces_[i].start.normal = place;
      pieces_[i].from = pieces_[i].start(to_);
      if (pieces_[c].source != kPivot) {
        pieces_[c].start = radial(c, place);
      } else {
        const Vec fixed = pieces_[c].start.normal;
        pieces_[c].start = {Junction::Kind::kStraight, place, {}, fixed, 0};
      }
      pieces_[c].from = pieces_[c].start(to_);
    }
    expect_death(a, d);
    expect_death(c, d);
  }

  struct Link {
    std::int32_t prev = 0, next = 0;  // next < 0: dead
    std::uint32_t stamp = 0;
  };
  std::span<const Source> sources_;
  std::span<Piece> pieces_;
  double to_;
  std::vector<Link> links_;
  std::int32_t alive_ = 0;  // pieces with a source
  std::priority_queue<Death, std::vector<Death>, std::greater<>> deaths_;
};

// Pieces whose ends at the asked distance lie the wrong way round.
void list_inverted(std::span<const Source> sources, std::span<const Piece> pieces, std::vector<std::int32_t>& inverted) {
  inverted.clear();
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Vec end = pieces[i + 1 < pieces.size() ? i + 1 : 0].from;
    if (dot(end - pieces[i].from, sources[pieces[i].source].along) < 0) inverted.push_back(std::int32_t(i));
  }
}

}  // namespace

void move(std::span<const Source> sources, Component& component, double from, double to) {
  // In place: what is left of a loop is no longer than the loop.
  std::vector<std::int32_t> inverted;
  std::vector<Piece> left;
  std::size_t begin = 0, written = 0, loops = 0;
  const auto write = [&](std::span<const Piece> pieces) {
    if (pieces.data() != component.pieces.data() + written)
      std::copy(pieces.begin(), pieces.end(), component.pieces.begin() + std::ptrdiff_t(written));
    written += pieces.size();
    component.ends[loops++] = std::uint32_t(written);
  };
  for (std::size_t k = 0; k < component.ends.size(); ++k) {
    const std::span<Piece> pieces(component.pieces.data() + begin, component.ends[k] - begin);
    begin = component.ends[k];
    for (Piece& piece : pieces) piece.from = piece.start(to);
    list_inverted(sources, pieces, inverted);
    if (inverted.empty()) {
      write(pieces);
      continue;
    }
    Loop loop(sources, pieces, to);
    for (const std::int32_t i : inverted) loop.expect_death(i, from);
    if (!loop.run()) continue;
    left.clear();
    loop.collect(left);
    write(left);
  }
  component.pieces.resize(written);
  component.ends.resize(loops);
}

}  // namespace firn::slice::wavefront
