// Holds the size of the largest single allocation of this thread since that size was last set to 0.
#pragma once

#include <cstddef>

namespace firn::test {

std::size_t& largest_allocation();

}  // namespace firn::test
