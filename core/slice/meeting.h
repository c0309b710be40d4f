// Do rings meet each other?
#pragma once

#include <cstdint>
#include <vector>

#include "core/slice/chains.h"
#include "core/slice/offset_rings.h"

namespace firn::slice {

/// meeting_of() for many sets of rings, with working memory of its own.
class MeetingCheck {
 public:
  Meeting operator()(const Rings& rings);

 private:
  Chains chains_;
  std::vector<std::uint32_t> next_;
};

}  // namespace firn::slice
