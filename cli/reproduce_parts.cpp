#include "cli/reproduce_parts.h"

namespace firn {

// {paper, name, what, seconds on one core, function of reproduce_parts.h}
const std::vector<ReproducePart>& reproduce_parts() {
  static const std::vector<ReproducePart> parts{
      {"lu", "figs-13-15", "Figs. 13-15: two materials, the junction of two pipes", 25, &reproduce_lu_materials},
  };
  return parts;
}

}  // namespace firn
