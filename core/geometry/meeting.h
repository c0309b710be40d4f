// Do rings meet each other?
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/chains.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// Do any two edges have a point in common that is not the corner between neighbours (a contact), or even
/// cross?
enum class Meeting { kApart, kContact, kCrossing };
Meeting meeting_of(const Rings& rings);

/// meeting_of() for many sets of rings, with working memory of its own.
class MeetingCheck {
 public:
  /// Edges of the same or of two rings.
  struct Pair {
    std::uint32_t one, other;
  };
  /// @param within units: lists edges that run against each other and may be no further apart; 0: none
  Meeting operator()(const Rings& rings, double within = 0);
  /// Of the rings checked last.
  std::span<const Pair> facing() const { return facing_; }
  std::uint32_t next(std::uint32_t edge) const { return next_[edge]; }
  /// If they were not apart: one of the edges that met worst.
  std::uint32_t met() const { return met_; }

 private:
  void add_chains(const Point* points, std::uint32_t begin, std::uint32_t end);
  Chains chains_;
  std::vector<std::uint32_t> next_;
  std::vector<Pair> facing_;
  std::uint32_t met_ = 0;
};

}  // namespace firn::slice
