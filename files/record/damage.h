// DamageList holds the damage that a reader found in a file, in bounded memory.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace firn::record {

struct Damage {
  std::uint64_t offset = 0;  ///< first byte in the file
  std::uint64_t bytes =
      0;  ///< bytes that are unusable or cannot be trusted; 0 = some bytes or records are missing here
  std::string_view reason;  ///< static text
  std::uint64_t lost =
      0;  ///< records or events that the reader could not return (0 if nothing is lost, e.g. a duplicate)
};

class DamageList {
 public:
  void add(const Damage& d) {
    ++count_;
    lost_ += d.lost;
    if (list_.size() < kKept) list_.push_back(d);
  }
  /// Returns the first kKept, in file order.
  const std::vector<Damage>& list() const { return list_; }
  std::uint64_t count() const { return count_; }
  std::uint64_t lost() const { return lost_; }
  static constexpr std::size_t kKept = 10000;

 private:
  std::vector<Damage> list_;
  std::uint64_t count_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace firn::record
