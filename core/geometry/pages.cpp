#include "core/geometry/pages.h"

#include <sys/mman.h>

#include <memory>

namespace firn::geometry {

void ask_for_pages([[maybe_unused]] std::span<std::byte> memory) {
#ifdef MADV_POPULATE_WRITE
  constexpr std::size_t kPage = 4096;
  void* at = memory.data();
  std::size_t left = memory.size();
  if (std::align(kPage, kPage, at, left)) ::madvise(at, left / kPage * kPage, MADV_POPULATE_WRITE);
#endif
}

}  // namespace firn::geometry
