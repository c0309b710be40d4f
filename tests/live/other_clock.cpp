// A library to be preloaded into programs (LD_PRELOAD): their clocks are off by the numbers of the file
// FIRN_CLOCK_FILE, which every process maps, as other_clock.h has them. The kernel's waits stay as they are,
// as they do while a computer sleeps.
#include "tests/live/other_clock.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>

namespace {

using firn::test::ClockError;

constexpr std::int64_t kNsPerS = 1'000'000'000;

int real_clock(clockid_t clock, timespec* t) {
  using Function = int(clockid_t, timespec*);
  static auto* const next = reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, "clock_gettime"));
  return next(clock, t);
}

std::int64_t ns(const timespec& t) { return std::int64_t(t.tv_sec) * kNsPerS + t.tv_nsec; }

const volatile ClockError* error_of_clocks() {
  static const volatile ClockError* const mapped = []() -> const volatile ClockError* {
    const char* const file = std::getenv("FIRN_CLOCK_FILE");
    const int fd = file ? ::open(file, O_RDONLY | O_CLOEXEC) : -1;
    if (fd < 0) return nullptr;
    void* const page = ::mmap(nullptr, sizeof(ClockError), PROT_READ, MAP_SHARED, fd, 0);
    ::close(fd);
    return page == MAP_FAILED ? nullptr : static_cast<const volatile ClockError*>(page);
  }
  ();
  return mapped;
}

/// The time at which this process first asked.
std::int64_t began_ns() {
  static const std::int64_t began = [] {
    timespec t{};
    real_clock(CLOCK_BOOTTIME, &t);
    return ns(t);
  }();
  return began;
}

std::int64_t off_by_ns(clockid_t clock, const timespec& t) {
  const volatile ClockError* const e = error_of_clocks();
  if (!e) return 0;
  if (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE) return e->wall_ns;
  if (clock == CLOCK_MONOTONIC) return e->leap_ns;
  if (clock != CLOCK_BOOTTIME) return 0;
  const std::int64_t since = ns(t) - began_ns();
  return e->leap_ns + std::int64_t(double(since) * 1e-6 * double(e->drift_ppm));
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* t) noexcept {
  const int failed = real_clock(clock, t);
  if (failed != 0) return failed;
  const std::int64_t now = ns(*t) + off_by_ns(clock, *t);
  t->tv_sec = time_t(now / kNsPerS);
  t->tv_nsec = long(now % kNsPerS);
  return 0;
}

time_t time(time_t* to) noexcept {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  if (to) *to = t.tv_sec;
  return t.tv_sec;
}

int gettimeofday(timeval* to, void*) noexcept {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  to->tv_sec = t.tv_sec;
  to->tv_usec = t.tv_nsec / 1000;
  return 0;
}
}
