#include "print/live/busy_machine.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "core/options/for_people.h"
#include "drivers/link/driver_event.h"
#include "runtime/precedence.h"

namespace firn {

std::string busy_words(const std::string& reason, std::int32_t fault_code, double load, unsigned cores) {
  // Sentences of safety and of the nodes about somebody who came too late.
  constexpr std::array<std::string_view, 4> kLate{"no heartbeat", "lease", "has been busy", "silent"};
  // Faults that drivers raise when an answer or a change of state is not there in time.
  constexpr std::array<std::int32_t, 4> kTimeLimits{drivers::kLinkLost, drivers::kValveLost,
                                                    drivers::kTimeSlip, drivers::kLampOn};
  const auto named = [&](std::string_view words) { return reason.find(words) != reason.npos; };
  if (load <= cores ||
      (std::ranges::none_of(kLate, named) && std::ranges::find(kTimeLimits, fault_code) == kTimeLimits.end()))
    return "";
  return fmt::format("; this computer was busy (load {} on {} cores): {}", for_people(load), cores,
                     kPriorityRemedy);
}

std::string busy_words(const std::string& reason, std::int32_t fault_code) {
  double load = 0.0;
  return ::getloadavg(&load, 1) == 1
             ? busy_words(reason, fault_code, load, std::max(1U, std::thread::hardware_concurrency()))
             : "";
}

double longest_delay_s(double for_s) {
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  constexpr std::chrono::milliseconds kStep{1};
  const Precedence precedence;
  double longest_s = 0.0;
  const auto end = Clock::now() + Seconds(for_s);
  for (auto now = Clock::now(); now < end;) {
    const auto due = now + kStep;
    std::this_thread::sleep_until(due);
    now = Clock::now();
    longest_s = std::max(longest_s, Seconds(now - due).count());
  }
  return longest_s;
}

}  // namespace firn
