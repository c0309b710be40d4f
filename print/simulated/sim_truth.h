// Reads the world's answer to TRUTH on its control line, as the message that tests, audit and reports read.
#pragma once

#include <optional>
#include <string>

#include "firn/sim_truth_t.hpp"

namespace firn {

/// Reads "TRUTH layer droplets volume_mm3 nx ny pitch_x pitch_y origin_x origin_y h…"; returns nothing if the
/// line is not of that form.
std::optional<sim_truth_t> parse_truth_line(const std::string& line);

}  // namespace firn
