#include "tests/lcmtypes/allocations.h"

#include <algorithm>
#include <cstdlib>
#include <new>

namespace firn::test {

std::size_t& largest_allocation() {
  thread_local std::size_t largest = 0;
  return largest;
}

}  // namespace firn::test

void* operator new(std::size_t bytes) {
  std::size_t& largest = firn::test::largest_allocation();
  largest = std::max(largest, bytes);
  if (void* p = std::malloc(bytes ? bytes : 1)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
