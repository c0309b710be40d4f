// Where a run's messages go: one UDP port for each run, so that prints on one machine do not hear each other.
#pragma once

#include <cstdint>
#include <string>

namespace firn {

inline constexpr int kFirstBusPort = 21000;
inline constexpr int kBusPorts = 8000;

bool bus_port_is_free(int port);
/// The port that belongs to `run_id`, or the next free one. @throws std::runtime_error if none is free
int free_bus_port(std::int64_t run_id);

/// What --bus takes: nothing, in-process, or udpm://<multicast address>:<port>[?options]. @throws UsageError
/// naming what is wrong with `bus`
void check_bus(const std::string& bus);

}  // namespace firn
