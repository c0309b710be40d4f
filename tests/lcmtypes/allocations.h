// The largest single allocation of this thread since it was last set to 0.
#pragma once

#include <cstddef>

namespace firn::test {

std::size_t& largest_allocation();

}  // namespace firn::test
