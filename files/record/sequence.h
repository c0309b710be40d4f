// SequenceMap holds the offsets of the numbered pieces of a damaged file, to distinguish a gap (pieces lost)
// from a stray copy of a later block.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace firn::record {

class SequenceMap {
 public:
  bool built() const { return built_; }
  void add(std::uint64_t number, std::uint64_t offset) { places_.emplace_back(number, offset); }
  void finish() {
    std::sort(places_.begin(), places_.end());
    const std::size_t n = places_.size();
    farthest_.resize(2 * n);
    for (std::size_t i = 0; i < n; ++i) farthest_[n + i] = places_[i].second;
    for (std::size_t i = n; i-- > 1;) farthest_[i] = std::max(farthest_[2 * i], farthest_[2 * i + 1]);
    built_ = true;
  }
  /// Returns true if any of the numbers [from, to) is behind `offset`: the piece at `offset` with number `to`
  /// is then early.
  bool any_behind(std::uint64_t from, std::uint64_t to, std::uint64_t offset) const {
    const auto at = [&](std::uint64_t number) {
      return std::size_t(
          std::lower_bound(places_.begin(), places_.end(), std::pair{number, std::uint64_t{0}}) -
          places_.begin());
    };
    const std::size_t n = places_.size();
    for (std::size_t l = at(from) + n, r = at(to) + n; l < r; l /= 2, r /= 2) {
      if (l % 2 && farthest_[l++] > offset) return true;
      if (r % 2 && farthest_[--r] > offset) return true;
    }
    return false;
  }

 private:
  std::vector<std::pair<std::uint64_t, std::uint64_t>> places_;  // number, offset
  std::vector<std::uint64_t> farthest_;  // segment tree: largest offset below each node, leaves from n on
  bool built_ = false;
};

}  // namespace firn::record
