#include "print/progress.h"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/options/for_people.h"
#include "lcmtypes/told_heights.h"

namespace firn {

using namespace std::chrono_literals;

constexpr double kProgressUm = 1e3;  // per mm

/// No estimate is good to a part of a second.
static std::string eta_text(double left_s) { return "  ETA " + time_for_people(std::ceil(left_s)); }

ProgressLine::ProgressLine(const Pauses& pauses) : pauses_(pauses), terminal_(isatty(STDERR_FILENO) != 0) {}

bool ProgressLine::due() const {
  const auto pause = !shown_once_ ? pauses_.first : terminal_ ? pauses_.terminal : pauses_.plain;
  return Clock::now() - shown_ >= pause;
}

void ProgressLine::show(const std::string& text, bool last) {
  if (!last && !due()) return;
  text_ = terminal_ ? text.substr(0, std::size_t(std::max(1, columns() - 1))) : text;
  std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", text_.c_str());
  std::fflush(stderr);
  shown_ = Clock::now();
  line_open_ = true;
  shown_once_ = true;
}

void ProgressLine::note(const std::string& text) {
  const bool again = terminal_ && line_open_;
  erase();
  std::fprintf(stderr, "%s\n", for_people(text).c_str());
  if (again) {
    std::fputs(text_.c_str(), stderr);
    line_open_ = true;
  }
  std::fflush(stderr);
}

int ProgressLine::columns() const {
  winsize size{};
  if (!terminal_) return 200;
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
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
  return eta_text(elapsed_s() * (1.0 - fraction) / fraction);
}

PrintProgress::PrintProgress(std::string title, const LabWords& words)
    : title_(std::move(title)), words_(words), line_({0ms, 0ms, 2000ms}) {}

void PrintProgress::foretell(std::map<int, double> layer_s, double time_scale) {
  foretold_s_ = std::move(layer_s);
  for (auto& [layer, s] : foretold_s_) s /= time_scale;
}

void PrintProgress::note(const std::string& text) {
  if (text.starts_with("the print waits") && held_since_s_ < 0.0) held_since_s_ = line_.elapsed_s();
  if (text.starts_with("the print goes on") && held_since_s_ >= 0.0) {
    held_s_ += line_.elapsed_s() - held_since_s_;
    held_since_s_ = -1.0;
  }
  line_.note(text);
}

std::string layer_text(const std::string& title, const LabWords& words, const layer_metrics_t& m,
                       double left_s, int columns) {
  const bool beyond = m.layer > m.layers_expected;
  const std::string layer = beyond ? fmt::format("layer {:>3}, {} expected", m.layer, m.layers_expected)
                                   : fmt::format("layer {:>3}/{:<3}", m.layer, m.layers_expected);
  const std::string left = left_s < 0.0 ? "" : eta_text(left_s);
  const double fraction = m.layers_expected > 0 ? std::min(1.0, double(m.layer) / m.layers_expected) : 0.0;
  const auto filled = std::size_t(fraction * 20.0);
  std::string front, middle;
  const bool told = heights_told(m);
  std::string text = layer + (told ? fmt::format("  RMS {:>9}", words.length(m.rms_mm * kProgressUm))
                                   : "  heights not measured");
  if (m.rows_lost > 0) text += fmt::format("  {} LOST", counted(std::uint64_t(m.rows_lost), "row"));
  const auto fits = [&](const std::string& more) {
    return int((front + text + middle + left + more).size()) < columns;
  };
  if (!fits("")) return text;
  const std::string height = fmt::format("  height {:>9}", words.length(m.mean_height_mm * kProgressUm));
  if (told && fits(height)) middle = height;
  if (const std::string name = fmt::format("{:<10} ", title); fits(name)) front = name;
  const std::string bar = "[" + std::string(filled, '#') + std::string(20 - filled, '.') + "] ";
  if (fits(bar)) front += bar;
  return front + text + middle + left;
}

// The layers beyond the expected number are of a search that ends when nothing betters the part: nobody knows
// how many follow.
void PrintProgress::layer(const layer_metrics_t& told) {
  layer_metrics_t m = told;
  const auto foretold = foretold_s_.find(m.layer);
  if (foretold != foretold_s_.end()) m.layers_expected = foretold_s_.rbegin()->first;
  if (first_layer_ < 0) {
    first_layer_ = m.layer;
    first_s_ = printing_s();
  }
  const int done = m.layer - first_layer_, left = m.layers_expected - m.layer;
  const double left_s = foretold != foretold_s_.end() ? foretold_s_.rbegin()->second - foretold->second
                        : done > 0 && left > 0        ? (printing_s() - first_s_) * left / done
                                                      : -1.0;
  line_.show(layer_text(title_, words_, m, left_s, line_.columns()), m.layer == m.layers_expected);
}

StudyProgress::StudyProgress(std::size_t all, std::string noun)
    : all_(all), noun_(std::move(noun)), line_({0ms, 0ms, 2000ms}) {}

void StudyProgress::made(std::size_t done, std::size_t failed) {
  const std::string eta = line_.eta(all_ > 0 ? double(done) / double(all_) : 0.0);
  line_.show(fmt::format("{}/{}{}, {:.1f} {}s/s{}", done, counted(all_, noun_),
                         failed ? fmt::format(", {} failed", failed) : std::string(),
                         double(done) / std::max(line_.elapsed_s(), 1e-3), noun_, eta),
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
