// validity_words says how near a simulated world came to the limits of its theory.
#pragma once

#include <string>
#include <vector>

#include "plant/inkjet/validity.h"

namespace firn {

/// Returns "; the world's slope of the wet surface reached 0.12 of 0.3" for each limit, or "".
std::string validity_words(const std::vector<plant::Validity>& validity);

}  // namespace firn
