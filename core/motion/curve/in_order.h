// put_in_order() computes the isotonic regression of numbers in the maximum norm: the sequence that does not
// fall and is nearest to them.
#pragma once

#include <vector>

namespace firn::motion {

/// Each number becomes the mean of the largest up to it and the smallest from it on. It moves by at most half
/// of the largest fall, and no other sequence that does not fall moves them by less. One that does not fall
/// stays as it is.
void put_in_order(std::vector<double>& values);

}  // namespace firn::motion
