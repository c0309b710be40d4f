#include "tests/replay/live_bytes.h"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> live = 0, peak = 0;

void* counted(std::size_t bytes) {
  void* const at = std::malloc(bytes);
  if (!at) throw std::bad_alloc();
  const std::size_t held = ::malloc_usable_size(at), now = live.fetch_add(held) + held;
  for (std::size_t before = peak; before < now && !peak.compare_exchange_weak(before, now);) {
  }
  return at;
}

void released(void* at) {
  live -= ::malloc_usable_size(at);
  std::free(at);
}

}  // namespace

void* operator new(std::size_t bytes) { return counted(bytes); }
void* operator new[](std::size_t bytes) { return counted(bytes); }
void operator delete(void* at) noexcept { released(at); }
void operator delete[](void* at) noexcept { released(at); }
void operator delete(void* at, std::size_t) noexcept { released(at); }
void operator delete[](void* at, std::size_t) noexcept { released(at); }

namespace firn::test {

std::size_t peak_live_bytes_of(const std::function<void()>& work) {
  const std::size_t before = live;
  peak = before;
  work();
  return peak - before;
}

}  // namespace firn::test
