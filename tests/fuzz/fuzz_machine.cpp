// Any text as a machine file.
#include <cmath>
#include <string>

#include "config/error.h"
#include "config/machine.h"
#include "core/motion/kinematics/fault.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Machine machine;
  try {
    machine = parse_machine(std::string(reinterpret_cast<const char*>(data), size), "fuzz.toml");
  } catch (const ConfigError& e) {
    require(std::string(e.what()).find("fuzz.toml") == 0, "an error names the file");
    return 0;
  }
  for (const Field& f : machine_fields(machine))
    require(broken_limit(f).empty(), "a machine that was read keeps every limit");
  deposition::check(valve_limits(machine.valve));
  require(std::isfinite(valve_setting(machine.valve).curve.frequency_hz(1.0)), "the valve has a curve");
  if (machine.kind == "aerosol") return 0;
  require(make_arm(machine)->joints() >= 2, "the machine has joints");
  motion::check_limits(motion_limits(machine), make_arm(machine)->joints());
  return 0;
}
