#include "print/labs/print_labs.h"

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

}  // namespace firn
