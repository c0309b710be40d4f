// Has the front passed a place?
#pragma once

#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "core/slice/chains.h"
#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {

/// Sources two by two, so that a place is held against both at once, if it is near the box of a block of them. Keeps its working
/// memory.
class PassedBy {
 public:
  void clear() { count_ = 0; }
  bool empty() const { return count_ == 0; }
  void add(const Source& source) {
    if (count_ / kBlock == blocks_.size()) blocks_.emplace_back();
    Block& block = blocks_[count_ / kBlock];
    const double length = std::max(source.length, 0.0);  // a corner's is below 0
    const PairBox box = PairBox::of(source.at, source.at + length * source.along);
    block.box = count_ % kBlock ? block.box.with(box) : box;
    // The last one may stand alone: twice.
    Two& two = block.twos[count_ % kBlock / 2];
    for (std::size_t k = count_ % 2; k < 2; ++k) {
      two.at_x[k] = source.at.x, two.at_y[k] = source.at.y;
      two.along_x[k] = source.along.x, two.along_y[k] = source.along.y;
      two.length[k] = length;
    }
    ++count_;
  }
  /// Is any of them nearer to the place than `distance`?
  bool operator()(Vec place, double distance) const {
    const PairBox about = PairBox::of(place, place).grown(distance + 1);
    for (std::size_t first = 0; first < count_; first += kBlock) {
      const Block& block = blocks_[first / kBlock];
      if (block.box.meets(about) && near(block, std::min(kBlock, count_ - first), place, distance * distance)) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kBlock = 16;
  using Pair = PairBox::Pair;
  struct Two {
    double at_x[2], at_y[2], along_x[2], along_y[2], length[2];
  };
  struct Block {
    PairBox box;
    Two twos[kBlock / 2];
  };
  static Pair load(const double (&numbers)[2]) {
    Pair pair;
    std::memcpy(&pair, numbers, sizeof pair);
    return pair;
  }
  static bool near(const Block& block, std::size_t count, Vec place, double square) {
    const Pair x = {place.x, place.x}, y = {place.y, place.y}, none{}, limit = {square, square};
    auto nearer = none < none;
    for (const Two& two : std::span(block.twos).first((count + 1) / 2)) {
      const Pair along_x = load(two.along_x), along_y = load(two.along_y), length = load(two.length);
      const Pair off_x = x - load(two.at_x), off_y = y - load(two.at_y), along = off_x * along_x + off_y * along_y;
      const Pair ahead = along > none ? along : none, share = ahead < length ? ahead : length;
      const Pair away_x = off_x - share * along_x, away_y = off_y - share * along_y;
      nearer |= away_x * away_x + away_y * away_y < limit;
    }
    return (nearer[0] | nearer[1]) != 0;
  }
  std::vector<Block> blocks_;
  std::size_t count_ = 0;
};

}  // namespace firn::slice::wavefront
