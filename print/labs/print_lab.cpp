#include <algorithm>
#include <stdexcept>

#include "print/labs/print_labs.h"

namespace firn {

const PrintLab& print_lab(const Experiment& e) {
  const auto lab = std::ranges::find(print_labs(), std::string_view(e.lab.kind), &PrintLab::name);
  if (lab == print_labs().end())
    throw std::invalid_argument("lab.kind = \"" + e.lab.kind + "\": cannot be printed");
  return **lab;
}

Blobs make_inputs(const Experiment& e, const std::filesystem::path& folder) {
  return print_lab(e).make_inputs(e, folder);
}

void complete_experiment(Experiment& e, const Blobs& inputs) {
  if (const PrintLab& lab = print_lab(e); lab.complete) lab.complete(e, inputs);
}

void check_inputs(const Experiment& e, const Blobs& inputs) {
  if (const PrintLab& lab = print_lab(e); lab.check_inputs) lab.check_inputs(e, inputs);
}

}  // namespace firn
