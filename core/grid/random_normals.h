// random_normals() and philox_blocks() draw many numbers at once: those of random_normal() and philox4x32(),
// to the last bit.
#pragma once

#include <span>

#include "core/grid/random.h"

namespace firn {

/// out[n] = random_normal(first with the cell first.cell + n).
void random_normals(const DrawKey& first, std::span<double> out);

/// out[n] = philox4x32(first with the first word raised by n, key).
void philox_blocks(const PhiloxBlock& first, const std::array<std::uint32_t, 2>& key,
                   std::span<PhiloxBlock> out);

}  // namespace firn
