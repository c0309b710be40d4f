#include "tests/print/disk_faults.h"

#include <cerrno>
#include <cstring>
#include <string>

namespace {

bool armed = false;
std::string watched;
std::uint64_t calls_seen = 0, fails_at = 0;
bool keeps_failing = false;

bool watching() { return armed; }

bool refuses(const char* path) {
  if (!armed || !path || std::strncmp(path, watched.c_str(), watched.size()) != 0) return false;
  ++calls_seen;
  const bool now = fails_at != 0 && (calls_seen == fails_at || (keeps_failing && calls_seen > fails_at));
  if (now) errno = ENOSPC;
  return now;
}

}  // namespace

#include "tests/support/write_calls.h"

namespace firn::test {

DiskFaults::DiskFaults(const std::filesystem::path& folder, std::uint64_t fails, bool stays) {
  watched = std::filesystem::absolute(folder).string();
  calls_seen = 0;
  fails_at = fails;
  keeps_failing = stays;
  armed = true;
}
DiskFaults::~DiskFaults() { armed = false; }

std::uint64_t DiskFaults::calls() const { return calls_seen; }

}  // namespace firn::test
