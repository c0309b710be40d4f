#include "print/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace firn {

using Clock = std::chrono::steady_clock;

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() { done(); }

void ProgressLine::show(const std::string& text, bool last) {
  const auto now = Clock::now();
  if (!terminal_ && !last && line_open_ && now - shown_ < std::chrono::seconds(2)) return;
  std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", text.c_str());
  std::fflush(stderr);
  shown_ = now;
  line_open_ = true;
}

void ProgressLine::done() {
  if (terminal_ && line_open_) std::fputc('\n', stderr);
  line_open_ = false;
}

PrintProgress::PrintProgress(std::string title) : title_(std::move(title)), began_(Clock::now()) {}

void PrintProgress::layer(const layer_metrics_t& m) {
  const double elapsed = std::chrono::duration<double>(Clock::now() - began_).count();
  const int all = std::max(m.layers_expected, m.layer);
  const double fraction = all > 0 ? double(m.layer) / all : 0.0;
  std::string eta;
  if (m.layer > 0) eta = fmt::format("  ETA {:.0f} s", elapsed / m.layer * (all - m.layer));
  std::string bar;
  if (line_.terminal()) {
    const int filled = int(fraction * 20.0);
    bar = "[" + std::string(std::size_t(filled), '#') + std::string(std::size_t(20 - filled), '.') + "] ";
  }
  line_.show(fmt::format("{:<10} {}layer {:>3}/{:<3}  height {:7.2f} um  RMS {:6.2f} um{}", title_, bar,
                         m.layer, all, m.mean_height_mm * 1e3, m.rms_mm * 1e3, eta),
             m.layer == all);
}

double StudyProgress::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - began_).count();
}

void StudyProgress::printed(std::size_t done, std::size_t failed) {
  const double elapsed = elapsed_s();
  const double eta = done > 0 ? elapsed / double(done) * double(all_ - done) : 0.0;
  line_.show(fmt::format("{}/{} prints{}, {:.1f} prints/s  ETA {:.0f} s", done, all_,
                         failed ? fmt::format(", {} failed", failed) : std::string(),
                         double(done) / std::max(elapsed, 1e-3), eta),
             done == all_);
}

}  // namespace firn
