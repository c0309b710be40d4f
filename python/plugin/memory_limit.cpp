#include "python/plugin/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <mutex>

namespace firn::python {
namespace {

std::mutex mutex;
int calls = 0;
rlimit before{};

// The machine's memory, or the share of it that the control group has. Its file holds "max" for no limit.
rlim_t memory_bytes() {
  const auto page = rlim_t(sysconf(_SC_PAGESIZE));
  rlim_t bytes = rlim_t(sysconf(_SC_PHYS_PAGES)) * page;
  rlim_t limit = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> limit) bytes = std::min(bytes, limit);
  return bytes;
}

rlim_t mapped_bytes() {
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * rlim_t(sysconf(_SC_PAGESIZE));
}

}  // namespace

MemoryLimit::MemoryLimit() {
  const std::lock_guard lock(mutex);
  if (calls++ > 0 || getrlimit(RLIMIT_AS, &before) != 0) return;
  const rlimit during{std::min(before.rlim_cur, mapped_bytes() + memory_bytes() / 2), before.rlim_max};
  setrlimit(RLIMIT_AS, &during);
}

MemoryLimit::~MemoryLimit() {
  const std::lock_guard lock(mutex);
  if (--calls == 0) setrlimit(RLIMIT_AS, &before);
}

}  // namespace firn::python
