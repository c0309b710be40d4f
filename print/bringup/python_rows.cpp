// Rows of instruments that a driver class in Python drives: its author alone knows them.
#include "config/device_kinds.h"
#include "print/bringup/bringup.h"

namespace firn {
namespace {

bool through_firn(const Experiment& e, std::string_view node) { return !has_own_port(e, node); }
bool by_itself(const Experiment& e, std::string_view node) { return has_own_port(e, node); }

constexpr BringupRow kPythonRows[] = {
    {59, "python",
     "its safe_bytes alone make it safe, sent while it works (firn device LAB NODE raw --unsafe)",
     "safe_bytes of the class", nullptr, &through_firn},
    {60, "python", "it is safe when its program was killed while it worked: its own watchdog or a relay",
     "safe() of the class", nullptr, &by_itself},
};

}  // namespace

std::span<const BringupRow> python_rows() { return kPythonRows; }

}  // namespace firn
