#include "print/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace firn {

using namespace std::chrono_literals;

ProgressLine::ProgressLine(const Pauses& pauses) : pauses_(pauses), terminal_(isatty(STDERR_FILENO) != 0) {}

bool ProgressLine::due() const {
  const auto pause = !shown_once_ ? pauses_.first : terminal_ ? pauses_.terminal : pauses_.plain;
  return Clock::now() - shown_ >= pause;
}

void ProgressLine::show(const std::string& text, bool last) {
  if (!last && !due()) return;
  std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", text.c_str());
  std::fflush(stderr);
  shown_ = Clock::now();
  line_open_ = true;
  shown_once_ = true;
}

void ProgressLine::done() {
  if (terminal_ && line_open_) std::fputc('\n', stderr);
  line_open_ = false;
}

void ProgressLine::erase() {
  if (terminal_ && line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
}

double ProgressLine::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - began_).count();
}

std::string ProgressLine::bar(double fraction) const {
  if (!terminal_) return {};
  const int filled = int(fraction * 20.0);
  return "[" + std::string(std::size_t(filled), '#') + std::string(std::size_t(20 - filled), '.') + "] ";
}

std::string ProgressLine::eta(double fraction) const {
  if (fraction <= 0.0) return {};
  return fmt::format("  ETA {:.0f} s", elapsed_s() * (1.0 - fraction) / fraction);
}

PrintProgress::PrintProgress(std::string title) : title_(std::move(title)), line_({0ms, 0ms, 2000ms}) {}

void PrintProgress::layer(const layer_metrics_t& m) {
  const int all = std::max(m.layers_expected, m.layer);
  const double fraction = all > 0 ? double(m.layer) / all : 0.0;
  const std::string lost = m.rows_lost > 0 ? fmt::format("  {} ROWS LOST", m.rows_lost) : std::string();
  line_.show(fmt::format("{:<10} {}layer {:>3}/{:<3}  height {:7.2f} um  RMS {:6.2f} um{}{}", title_,
                         line_.bar(fraction), m.layer, all, m.mean_height_mm * 1e3, m.rms_mm * 1e3, lost,
                         line_.eta(fraction)),
             m.layer == all);
}

void PrintProgress::message(const std::string& text) {
  line_.erase();
  std::fprintf(stderr, "%s\n", text.c_str());
}

StudyProgress::StudyProgress(std::size_t all) : all_(all), line_({0ms, 0ms, 2000ms}) {}

void StudyProgress::printed(std::size_t done, std::size_t failed) {
  const std::string eta = line_.eta(all_ > 0 ? double(done) / double(all_) : 0.0);
  line_.show(fmt::format("{}/{} prints{}, {:.1f} prints/s{}", done, all_,
                         failed ? fmt::format(", {} failed", failed) : std::string(),
                         double(done) / std::max(line_.elapsed_s(), 1e-3), eta),
             done == all_);
}

JobProgress::JobProgress(std::string title) : title_(std::move(title)), line_({2000ms, 200ms, 2000ms}) {}

void JobProgress::show(double fraction, const std::string& done) {
  if (!line_.due()) return;
  fraction = std::clamp(fraction, 0.0, 1.0);
  line_.show(fmt::format("{} {}{:5.1f} %{}{}{}", title_, line_.bar(fraction), 100.0 * fraction,
                         done.empty() ? "" : "  ", done, line_.eta(fraction)));
}

}  // namespace firn
