#include "config/experiment.h"

namespace firn {

bool has_two_jets(const Experiment& e) {
  return e.geometry.solid.kind != "none" || e.control.scheme == "registration";
}

}  // namespace firn
