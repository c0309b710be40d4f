#include "print/labs/product.h"

#include <algorithm>
#include <stdexcept>

#include "print/inputs/driver_input.h"

namespace firn {

const PrintLab& print_lab(const Product& product, const Experiment& e) {
  const auto lab = std::ranges::find(product.labs, std::string_view(e.lab.kind), &PrintLab::name);
  if (lab == product.labs.end())
    throw std::invalid_argument("lab.kind = \"" + e.lab.kind + "\": cannot be printed");
  return **lab;
}

Blobs make_inputs(const Product& product, const Experiment& e, const std::filesystem::path& folder) {
  Blobs inputs = print_lab(product, e).make_inputs(e, folder, product.meshes);
  add_driver_inputs(e, folder, inputs);
  return inputs;
}

void complete_experiment(const Product& product, Experiment& e, const Blobs& inputs) {
  if (const PrintLab& lab = print_lab(product, e); lab.complete) lab.complete(e, inputs);
}

void check_inputs(const Product& product, const Experiment& e, const Blobs& inputs) {
  if (const PrintLab& lab = print_lab(product, e); lab.check_inputs) lab.check_inputs(e, inputs);
}

}  // namespace firn
