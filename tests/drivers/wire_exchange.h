// exchange_under_faults commands each instrument over real lines while its line is disturbed in every way of
// the fault menu, and holds each answer against the simulated world's truth.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "tests/drivers/real_wire.h"

namespace firn::drivers::test {

struct ExchangeFigures {
  std::string instrument;
  std::int64_t exchanges = 0;  ///< requests that left the host
  std::int64_t commands = 0, faults = 0;
  std::int64_t wrong = 0;     ///< answers that are not the truth
  std::int64_t repeats = 0;   ///< acts carried out more often than commanded
  double slowest_s = 0.0;     ///< from a fault's end to the next command that is taken
  std::string slowest_after;  ///< that fault
  std::string first_wrong;
};

/// @param exchanges of each instrument, at least
/// @param done is called with the figures of each instrument
/// @param only this one; empty: all
void exchange_under_faults(RealWire::Kind kind, std::int64_t exchanges, std::uint64_t seed,
                           const std::function<void(const ExchangeFigures&)>& done,
                           std::string_view only = {});

}  // namespace firn::drivers::test
