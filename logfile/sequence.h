// Where the numbered pieces of a damaged file stand: tells a gap (pieces lost) from a stray copy of a later block.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace firn::logfile {

class SequenceMap {
 public:
  bool built() const { return built_; }
  void add(std::uint64_t number, std::uint64_t offset) { places_.emplace_back(number, offset); }
  void finish() {
    std::sort(places_.begin(), places_.end());
    built_ = true;
  }
  /// Does any of the numbers [from, to) stand behind `offset`? Then what stands at `offset` with number `to` is early.
  bool any_behind(std::uint64_t from, std::uint64_t to, std::uint64_t offset) const {
    auto it = std::lower_bound(places_.begin(), places_.end(), std::pair{from, std::uint64_t{0}});
    for (; it != places_.end() && it->first < to; ++it)
      if (it->second > offset) return true;
    return false;
  }

 private:
  std::vector<std::pair<std::uint64_t, std::uint64_t>> places_;  // number, offset
  bool built_ = false;
};

}  // namespace firn::logfile
