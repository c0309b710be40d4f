// random_normals() draws many normal numbers at once: those of random_normal(), to the last bit.
#pragma once

#include <span>

#include "core/grid/random.h"

namespace firn {

/// out[n] = random_normal(first with the cell first.cell + n).
void random_normals(const DrawKey& first, std::span<double> out);

}  // namespace firn
