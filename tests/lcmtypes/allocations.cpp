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

// All forms that end in operator delete below: a sanitizer reports a pair with another allocator's form.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  std::size_t& largest = firn::test::largest_allocation();
  largest = std::max(largest, bytes);
  return std::malloc(bytes ? bytes : 1);
}
void* operator new(std::size_t bytes) {
  if (void* p = operator new(bytes, std::nothrow)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
