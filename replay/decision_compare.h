// Compares decisions cell by cell: what a replay with changed settings would have printed otherwise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace firn::replay {

/// Returns the number of cells in which two decisions differ: LAYER_PLAN by droplets and ink, CONTROL_SURFACE
/// by action; all cells where one prints and the other does not, or `b` does not decode. Nothing for other
/// channels and where `a` does not decode.
std::optional<std::uint64_t> differing_cells(std::string_view channel, std::span<const std::byte> a,
                                             std::span<const std::byte> b);

}  // namespace firn::replay
