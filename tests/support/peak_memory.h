// peak_of measures the memory of some work.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>

namespace firn::test {

/// Returns the peak of the resident memory of a process of its own above its start, in bytes. @throws
/// std::runtime_error if that process did not come to the end of the work
inline std::size_t peak_of(const std::function<void()>& work) {
  int ends[2];
  if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = ::fork();
  if (child == 0) {
    const auto kilobytes = [](const std::string& key) {
      std::ifstream status("/proc/self/status");
      for (std::string line; std::getline(status, line);)
        if (line.starts_with(key)) return std::stoul(line.substr(key.size()));
      return 0ul;
    };
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins anew
    const std::size_t before = kilobytes("VmRSS:");
    work();
    const std::size_t peak = (kilobytes("VmHWM:") - before) * 1024;
    const bool told = ::write(ends[1], &peak, sizeof peak) == sizeof peak;
    ::_exit(told ? 0 : 1);
  }
  std::size_t peak = 0;
  const bool told = ::read(ends[0], &peak, sizeof peak) == sizeof peak;
  ::waitpid(child, nullptr, 0);
  ::close(ends[0]);
  ::close(ends[1]);
  if (!told) throw std::runtime_error("the work ended its process");
  return peak;
}

}  // namespace firn::test
