// Computes the UDP port of a run's messages: one port for each run, so that prints on one machine do not hear
// each other.
#pragma once

#include <cstdint>
#include <string>

namespace firn {

inline constexpr int kFirstBusPort = 21000;
inline constexpr int kBusPorts = 8000;

bool bus_port_is_free(int port);
/// Returns the port that belongs to `run_id`, or the next free one. @throws std::runtime_error if no port is
/// free
int free_bus_port(std::int64_t run_id);

/// Checks the value of --bus: nothing, in-process, or udpm://<multicast address>:<port>[?options].
/// @throws UsageError naming the fault of `bus`
void check_bus(const std::string& bus);

}  // namespace firn
