#include "files/record/part_file.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <system_error>
#include <utility>

namespace firn::record {
namespace {

enum Use : int { kFree, kBeingWritten, kHeld };

// Fixed storage: a signal handler may neither allocate nor lock.
struct Slot {
  std::atomic<int> use{kFree};
  std::array<char, 4096> path{};
};
std::array<Slot, 64> slots;
std::atomic<pid_t> owner{0};

int hold(const std::filesystem::path& path) {
  const std::string& name = path.native();
  if (name.size() >= slots[0].path.size()) return -1;
  for (std::size_t n = 0; n < slots.size(); ++n) {
    int free = kFree;
    if (!slots[n].use.compare_exchange_strong(free, kBeingWritten)) continue;
    std::memcpy(slots[n].path.data(), name.c_str(), name.size() + 1);
    slots[n].use.store(kHeld);
    return int(n);
  }
  return -1;
}

void end_by(int signal) {
  if (::getpid() == owner.load())  // a forked child holds its parent's names
    for (const Slot& slot : slots)
      if (slot.use.load() == kHeld) ::unlink(slot.path.data());
  std::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

PartFile::PartFile(std::filesystem::path path) : path_(std::move(path)), slot_(hold(path_)) {}

PartFile::~PartFile() {
  if (slot_ >= 0) slots[std::size_t(slot_)].use.store(kFree);
}

void PartFile::remove() const {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void remove_parts_on_signals() {
  owner.store(::getpid());
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    ::sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_DFL) continue;
    struct sigaction act {};
    act.sa_handler = end_by;
    ::sigaction(signal, &act, nullptr);
  }
}

}  // namespace firn::record
