#include "print/bringup/raw_line.h"

#include <poll.h>

#include <algorithm>

#include "drivers/link/line_cleaner.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

constexpr double kOpenWithin_s = 10.0;  // of a port that says nothing about why it does not open
constexpr std::int64_t kTroubleWithin_us = 3'000'000;

}  // namespace

RawLine::RawLine(const PortAddress& address) : ports_({address}) {
  ports_.open_all(monotonic_us());
  const std::int64_t begin = monotonic_us(), until = begin + std::int64_t(kOpenWithin_s * 1e6);
  while (!open_ && monotonic_us() < until &&
         (trouble_.empty() || monotonic_us() < begin + kTroubleWithin_us)) {
    turn(20);
    trouble_ = ports_.trouble();
  }
}

void RawLine::turn(int max_ms) {
  std::vector<pollfd> fds;
  ports_.add_to(fds);
  ::poll(fds.data(), fds.size(), max_ms);
  ports_.service(
      monotonic_us(), [this](PortId, LinkState link) { open_ = link == LinkState::kOpen; },
      [this](PortId, std::span<const std::byte> bytes) {
        heard_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      });
}

void RawLine::send(std::string_view bytes) { ports_.write(PortId{0}, bytes_of(bytes), false); }

std::string RawLine::ask(std::string_view bytes, const std::function<bool(std::string_view)>& whole,
                         double within_s) {
  turn(0);
  heard_.clear();
  const std::int64_t begin = monotonic_us(), until = begin + std::int64_t(within_s * 1e6);
  send(bytes);
  while (!whole(heard_) && monotonic_us() < until)
    turn(int(std::min<std::int64_t>(20, (until - begin) / 1000)));
  last_answer_s_ = double(monotonic_us() - begin) * 1e-6;
  return heard_;
}

std::string RawLine::ask_line(std::string_view bytes, char end, double within_s) {
  const auto whole = [end](std::string_view heard) {
    return drivers::cleaned(heard, end).find(end) != std::string::npos;
  };
  return drivers::cleaned(ask(bytes, whole, within_s), end);
}

void RawLine::wait(double s) {
  const std::int64_t until = monotonic_us() + std::int64_t(s * 1e6);
  while (monotonic_us() < until) turn(5);
}

}  // namespace firn
