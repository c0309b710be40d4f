#include "config/experiment.h"

namespace firn {

Experiment::Experiment() = default;
Experiment::Experiment(const Experiment& other) = default;
Experiment::Experiment(Experiment&& other) noexcept = default;
Experiment& Experiment::operator=(const Experiment& other) = default;
Experiment& Experiment::operator=(Experiment&& other) noexcept = default;
Experiment::~Experiment() = default;

bool has_two_jets(const Experiment& e) {
  return e.geometry.solid.kind != "none" || e.control.scheme == "registration";
}

}  // namespace firn
