// Validity holds how near a nature has come to the limits of the theory that it is computed by.
#pragma once

#include <string>

namespace firn::plant {

struct Validity {
  std::string quantity;  ///< in words
  double reached = 0.0,
         most = 0.0;  ///< largest since the print began; beyond `most` the theory does not hold
};

}  // namespace firn::plant
