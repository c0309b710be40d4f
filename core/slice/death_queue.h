// What dies next on a front that moves on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace firn::slice::wavefront {

/// A piece's death at a distance.
struct Death {
  double d;
  std::int32_t piece;
  std::uint32_t stamp;
  bool operator>(const Death& o) const { return d != o.d ? d > o.d : piece > o.piece; }
};

/// Deaths to come, told in their order: lists by distance, of which only the one that is being told is a heap.
class DeathQueue {
 public:
  /// @param about so many are expected
  void begin(double from, double to, std::size_t about) {
    first_.assign(std::min<std::size_t>(about, 1 << 16) + 1, kNone);
    from_ = from, per_unit_ = double(first_.size() - 1) / (to - from);
    here_ = 0;
    heap_.clear();
    listed_.clear();
  }
  /// Not before the one told last.
  void add(const Death& death) {
    const auto list = std::size_t(per_unit_ * (death.d - from_));
    if (list <= here_) return push(death);
    listed_.push_back({death, std::exchange(first_[list], std::int32_t(listed_.size()))});
  }
  /// @return false if there is none
  bool next(Death& death) {
    while (heap_.empty()) {
      if (++here_ >= first_.size()) return false;
      for (std::int32_t i = first_[here_]; i != kNone; i = listed_[std::size_t(i)].next) push(listed_[std::size_t(i)].death);
    }
    std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
    death = heap_.back();
    heap_.pop_back();
    return true;
  }

 private:
  static constexpr std::int32_t kNone = -1;
  struct Listed {
    Death death;
    std::int32_t next;
  };
  void push(const Death& death) {
    heap_.push_back(death);
    std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
  }
  std::vector<std::int32_t> first_;  // listed, by distance
  std::vector<Listed> listed_;
  std::vector<Death> heap_;
  double from_ = 0, per_unit_ = 0;
  std::size_t here_ = 0;
};

}  // namespace firn::slice::wavefront
