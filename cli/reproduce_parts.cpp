#include "cli/reproduce_parts.h"

namespace firn {

// {paper, name, what, seconds on one core, function of reproduce_parts.h}
const std::vector<ReproducePart>& reproduce_parts() {
  static const std::vector<ReproducePart> parts{};
  return parts;
}

}  // namespace firn
