// Has the front passed a place?
#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "core/slice/wavefront.h"

namespace firn::slice::wavefront {

/// Sources two by two, so that a place is held against both at once. Keeps its working memory.
class PassedBy {
 public:
  void clear() { count_ = 0; }
  bool empty() const { return count_ == 0; }
  void add(const Source& source) {
    if (count_ / 2 == pairs_.size()) pairs_.emplace_back();
    Two& two = pairs_[count_ / 2];
    // The last one may stand alone: twice.
    for (std::size_t k = count_ % 2; k < 2; ++k) {
      two.at_x[k] = source.at.x, two.at_y[k] = source.at.y;
      two.along_x[k] = source.along.x, two.along_y[k] = source.along.y;
      two.length[k] = std::max(source.length, 0.0);  // a corner's is below 0
    }
    ++count_;
  }
  /// Is any of them nearer to the place than the root of `square`?
  bool operator()(Vec place, double square) const {
    const Pair x = {place.x, place.x}, y = {place.y, place.y}, none{}, limit = {square, square};
    for (std::size_t i = 0; i < (count_ + 1) / 2; ++i) {
      const Two& two = pairs_[i];
      const Pair along_x = load(two.along_x), along_y = load(two.along_y), length = load(two.length);
      const Pair off_x = x - load(two.at_x), off_y = y - load(two.at_y), along = off_x * along_x + off_y * along_y;
      const Pair ahead = along > none ? along : none, share = ahead < length ? ahead : length;
      const Pair away_x = off_x - share * along_x, away_y = off_y - share * along_y;
      const auto nearer = away_x * away_x + away_y * away_y < limit;
      if (nearer[0] | nearer[1]) return true;
    }
    return false;
  }

 private:
  using Pair = double __attribute__((vector_size(16)));
  struct Two {
    double at_x[2], at_y[2], along_x[2], along_y[2], length[2];
  };
  static Pair load(const double (&numbers)[2]) {
    Pair pair;
    std::memcpy(&pair, numbers, sizeof pair);
    return pair;
  }
  std::vector<Two> pairs_;
  std::size_t count_ = 0;
};

}  // namespace firn::slice::wavefront
