#include "runtime/serial_line.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

namespace firn {
namespace {

namespace fs = std::filesystem;

speed_t speed_of(int baud) {
  static constexpr std::array<std::pair<int, speed_t>, 12> kSpeeds{{{300, B300},
                                                                    {1200, B1200},
                                                                    {2400, B2400},
                                                                    {4800, B4800},
                                                                    {9600, B9600},
                                                                    {19200, B19200},
                                                                    {38400, B38400},
                                                                    {57600, B57600},
                                                                    {115200, B115200},
                                                                    {230400, B230400},
                                                                    {460800, B460800},
                                                                    {921600, B921600}}};
  for (const auto& [number, speed] : kSpeeds)
    if (number == baud) return speed;
  return B0;
}

bool configure(int fd, const PortAddress& a) {
  termios t{};
  if (::tcgetattr(fd, &t) != 0) return false;
  ::cfmakeraw(&t);
  t.c_cflag &= tcflag_t(~(HUPCL | CRTSCTS | CSIZE | PARENB | PARODD | CSTOPB));
  t.c_cflag |= CLOCAL | CREAD | (a.data_bits == 7 ? CS7 : CS8);
  if (a.parity != 'N') t.c_cflag |= PARENB;
  if (a.parity == 'O') t.c_cflag |= PARODD;
  if (a.stop_bits == 2) t.c_cflag |= CSTOPB;
  t.c_cc[VMIN] = t.c_cc[VTIME] = 0;
  if (::cfsetspeed(&t, speed_of(a.baud)) != 0 || ::tcsetattr(fd, TCSANOW, &t) != 0) return false;
  if (a.dtr != PortAddress::Dtr::kKeep) {
    int line = TIOCM_DTR;  // a pseudo terminal has no modem lines
    (void)::ioctl(fd, a.dtr == PortAddress::Dtr::kOn ? TIOCMBIS : TIOCMBIC, &line);
  }
  ::tcflush(fd, TCIOFLUSH);
  return true;
}

/// Returns the process that holds the flock; others may have the file open beside it. Empty: none.
std::string locker_of(const fs::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return {};
  char wanted[64];
  std::snprintf(wanted, sizeof wanted, "%02x:%02x:%llu", ::major(found.st_dev), ::minor(found.st_dev),
                static_cast<unsigned long long>(found.st_ino));
  std::ifstream locks("/proc/locks");
  std::string line, number, kind, mode, access, pid, inode;
  while (std::getline(locks, line)) {
    std::istringstream words(line);
    if (words >> number >> kind >> mode >> access >> pid >> inode && kind == "FLOCK" && inode == wanted)
      return pid;
  }
  return {};
}

}  // namespace

std::string holder_of(std::string_view file) {
  std::error_code ignored;
  const fs::path wanted = fs::canonical(fs::path(file), ignored);
  if (ignored) return {};
  const auto named = [](const std::string& pid) {
    std::string name;
    std::getline(std::ifstream("/proc/" + pid + "/comm"), name);
    return "process " + pid + " (" + name + ")";
  };
  if (const std::string pid = locker_of(wanted); !pid.empty()) return named(pid);
  for (const auto& process : fs::directory_iterator("/proc", ignored)) {
    const std::string pid = process.path().filename();
    if (pid.find_first_not_of("0123456789") != std::string::npos || pid == std::to_string(::getpid()))
      continue;
    std::error_code gone;
    for (const auto& fd : fs::directory_iterator(process.path() / "fd", gone)) {
      std::error_code unread;
      if (fs::read_symlink(fd.path(), unread) != wanted) continue;
      return named(pid);
    }
  }
  return {};
}

int open_serial_line(const PortAddress& a, std::string& why) {
  const auto held = [&] {
    const std::string holder = holder_of(a.place);
    return a.place + " is in use by " + (holder.empty() ? "another process" : holder);
  };
  const int fd = ::open(a.place.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    why = errno == EBUSY ? held() : a.place + ": " + std::strerror(errno);
    return -1;
  }
  if (!::isatty(fd))
    why = a.place + " is no serial line";
  else if (::flock(fd, LOCK_EX | LOCK_NB) != 0)
    why = held();
  else if (::ioctl(fd, TIOCEXCL) != 0 || !configure(fd, a))
    why = a.place + " does not take " + to_text(a) + ": " + std::strerror(errno);
  else
    return fd;
  ::close(fd);
  return -1;
}

void drop_unsent(int fd) { ::tcflush(fd, TCOFLUSH); }

}  // namespace firn
