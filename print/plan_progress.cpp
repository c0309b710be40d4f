#include "print/plan_progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace firn {

using Clock = std::chrono::steady_clock;

JobProgress::JobProgress(std::string title)
    : title_(std::move(title)), terminal_(isatty(STDERR_FILENO) != 0), began_(Clock::now()), shown_(began_) {}

JobProgress::~JobProgress() {
  if (terminal_ && line_open_) std::fputc('\n', stderr);
}

void JobProgress::show(double fraction, const std::string& done) {
  const auto now = Clock::now();
  const auto pause = std::chrono::milliseconds(terminal_ && line_open_ ? 200 : 2000);
  if (now - shown_ < pause) return;
  shown_ = now;
  line_open_ = true;
  fraction = std::clamp(fraction, 0.0, 1.0);
  const double elapsed = std::chrono::duration<double>(now - began_).count();
  std::string eta;
  if (fraction > 0.0) eta = fmt::format("  ETA {:.0f} s", elapsed * (1.0 - fraction) / fraction);
  std::string bar;
  if (terminal_) {
    const int filled = int(fraction * 20.0);
    bar = "[" + std::string(std::size_t(filled), '#') + std::string(std::size_t(20 - filled), '.') + "] ";
  }
  std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n",
               fmt::format("{} {}{:5.1f} %  {}{}", title_, bar, 100.0 * fraction, done, eta).c_str());
  std::fflush(stderr);
}

}  // namespace firn
