#include "runs/folder/lab_lock.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <span>

#include "config/devices.h"
#include "config/experiment.h"
#include "files/digest.h"
#include "files/record/file.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "plant/world/setup.h"
#include "runs/folder/run_folder.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

constexpr int kLowestInherited = 64;  // above the descriptors that a child process puts in place
// A lock in the run folder is its owner's; the users of a lab share the others.
constexpr mode_t kOwner = 0600, kEverybody = 0666;
constexpr int kPauseUs = 50'000, kPauses = 100;

struct Holder {
  long pid = 0;
  std::string run;
};

Holder read_holder(const fs::path& file) {
  Holder h;
  std::ifstream in(file);
  in >> h.pid >> std::ws;
  std::getline(in, h.run);
  return h;
}

bool lives(long pid) { return pid > 0 && (::kill(pid_t(pid), 0) == 0 || errno == EPERM); }

// In the system's folder of locks: the same for every user and every run.
fs::path shared_file(const std::string& address) {
  const fs::path folder = ::access("/run/lock", W_OK) == 0 ? "/run/lock" : "/tmp";
  return folder / ("firn-" + sha256_hex(std::as_bytes(std::span(address))).substr(0, 16) + ".lock");
}

// An existing file of another user is opened as it is: the system may refuse O_CREAT on it.
int open_lock(const fs::path& file, mode_t mode) {
  const int there = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (there >= 0 || errno != ENOENT) return there;
  const int made = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, mode);
  if (made >= 0) ::fchmod(made, mode);
  return made;
}

// Whoever gives a lock back removes its file: a lock on a removed file protects nothing.
bool still_named(int fd, const fs::path& file) {
  struct stat held {
  }, found{};
  return ::fstat(fd, &held) == 0 && ::stat(file.c_str(), &found) == 0 && held.st_ino == found.st_ino &&
         held.st_dev == found.st_dev;
}

}  // namespace

LabLock::LabLock(const RunFolder& run, const Experiment& experiment, const std::string& bus_url, Heirs heirs)
    : run_(fs::absolute(run.path()).lexically_normal().string()), heirs_(heirs) {
  const fs::path io = run.ports_path();
  try {
    fs::create_directories(io);
    const fs::path home = fs::canonical(io);
    const bool own = home == RunPaths(fs::canonical(run.path())).ports_path();
    take(home / run.instruments_lock_path().filename(), own ? "this run" : "the lab in " + home.string(),
         own ? kOwner : kEverybody);
    for (const std::string_view port : plant::world_config(experiment).kind->ports) {
      const fs::path place = fs::weakly_canonical(io / port);
      if (place.parent_path() != home)
        take(shared_file(place.string()), "the instrument at " + place.string(), kEverybody);
    }
    for (const auto& [node, address] : real_ports(experiment)) {
      if (address.kind == PortAddress::Kind::kPython) continue;  // only its class knows where it is
      const std::string place = address.kind == PortAddress::Kind::kTcp
                                    ? to_text(address)
                                    : fs::weakly_canonical(address.place).string();
      take(shared_file(place), node + " at " + place, kEverybody);
    }
    if (!bus_url.empty()) {
      const std::string bus = bus_url.substr(0, bus_url.find('?'));
      take(shared_file(bus), "the bus " + bus, kEverybody);
    }
  } catch (...) {
    release();
    throw;
  }
}

LabLock::~LabLock() { release(); }

void LabLock::release() {
  for (const Held& h : held_) {
    if (still_named(h.fd, h.file)) ::unlink(h.file.c_str());
    ::close(h.fd);
  }
  held_.clear();
}

void LabLock::take(const fs::path& file, const std::string& address, mode_t mode) {
  for (int pauses = 0;;) {
    int fd = open_lock(file, mode);
    if (fd < 0) throw record::FileError(file, 0, "cannot lock", errno);
    if (::flock(fd, LOCK_EX | LOCK_NB) == 0) {
      if (!still_named(fd, file)) {
        ::close(fd);
        continue;
      }
      if (heirs_ == Heirs::kChildren) {
        const int high = ::fcntl(fd, F_DUPFD, kLowestInherited);
        ::close(fd);
        if (high < 0) throw record::FileError(file, 0, "cannot lock", errno);
        fd = high;
      }
      held_.push_back({file, fd});
      const std::string who = std::to_string(::getpid()) + "\n" + run_ + "\n";
      if (::ftruncate(fd, 0) != 0 || ::pwrite(fd, who.data(), who.size(), 0) != ssize_t(who.size()))
        throw record::FileError(file, 0, "cannot write the lock's holder", errno);
      return;
    }
    const int error = errno;
    ::close(fd);
    if (error != EWOULDBLOCK && error != EINTR) throw record::FileError(file, 0, "cannot lock", error);
    const Holder holder = read_holder(file);
    const std::string whose =
        "process " + std::to_string(holder.pid) + ", run folder " + holder.run + "; only one print at a time";
    if (lives(holder.pid)) throw UsageError(run_ + ": " + address + " is in use by " + whose);
    if (++pauses > kPauses)
      throw UsageError(run_ + ": " + address + " is still in use by processes that were started by " + whose);
    ::usleep(kPauseUs);
  }
}

}  // namespace firn::runs
