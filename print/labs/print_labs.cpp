#include "print/labs/print_labs.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "print/labs/aerosol_print.h"
#include "print/labs/ice_print.h"
#include "print/labs/inkjet_print.h"

namespace firn {
namespace {

constexpr const PrintLab* kLabs[] = {
    &kInkjetPrint,
    &kIcePrint,
    &kAerosolPrint,
};

}  // namespace

std::span<const PrintLab* const> print_labs() { return kLabs; }

const PrintLab& print_lab(const Experiment& e) {
  const auto lab = std::ranges::find(kLabs, std::string_view(e.lab.kind), &PrintLab::name);
  if (lab == std::end(kLabs))
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
