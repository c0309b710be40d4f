#include "config/machine.h"

#include <algorithm>

#include "config/field_rules.h"
#include "config/field_texts.h"
#include "config/reader.h"

namespace firn {
namespace {

// The kinds of machines that have a section; all kinds have the sections that are not listed.
bool belongs(std::string_view section, std::string_view kind) {
  const auto starts = [&](std::string_view front) { return section.starts_with(front); };
  if (starts("scara") || starts("orientation") || starts("joint_") || starts("tool_")) return kind == "scara";
  if (starts("total") || starts("valve")) return kind != "aerosol";
  if (section == "axis_3" || starts("stage")) return kind == "stage";
  if (starts("axis_")) return kind != "scara";
  if (starts("aerosol")) return kind == "aerosol";
  return true;
}

bool ascends(const std::vector<double>& numbers) {
  return std::adjacent_find(numbers.begin(), numbers.end(), [](double a, double b) { return !(b > a); }) ==
         numbers.end();
}

void check_valve(const ValveConfig& v, const FieldRules& rules) {
  rules.require(v.table_hz.size() == v.table_mm3_s.size(), "valve.table_mm3_s",
                "must have as many entries as valve.table_hz");
  rules.require(ascends(v.table_hz), "valve.table_hz", "must ascend");
  rules.require(ascends(v.table_mm3_s), "valve.table_mm3_s", "must ascend");
  rules.require(v.pulse_s >= v.min_pulse_s, "valve.pulse_s", "must not be below valve.min_pulse_s");
  rules.require(v.max_duration_s / v.tick_s < 65536.5, "valve.max_duration_s",
                "must be at most 65,536 of valve.tick_s: entries have 16 bits");
}

}  // namespace

Machine parse_machine(const std::string& toml_text, const std::string& file_name) {
  Machine machine;
  const Origins origins = read_fields(machine_fields(machine), toml_text, file_name);
  const FieldRules rules(machine_fields(machine), origins, file_name);
  for (const auto& [key, origin] : origins) {
    const std::string section = key.substr(0, key.find('.'));
    rules.require(belongs(section, machine.kind), key,
                  "does not belong to a machine of kind \"" + machine.kind + "\"");
  }
  rules.require(machine.elbow != 0, "scara.elbow", "must be 1 or -1");
  for (std::size_t n = 0; n < machine.joint.size(); ++n)
    rules.require(machine.joint[n].low < machine.joint[n].high,
                  "joint_" + std::to_string(n + 1) + (n == 2 ? ".high_mm" : ".high_deg"),
                  "must be above the other end of the range");
  for (std::size_t n = 0; n < machine.axis.size(); ++n)
    rules.require(machine.axis[n].low < machine.axis[n].high, "axis_" + std::to_string(n + 1) + ".high_mm",
                  "must be above the other end of the range");
  check_valve(machine.valve, rules);
  return machine;
}

std::string machine_markdown() {
  Machine defaults;
  return "# Machines\n\n"
         "Written by `firn config docs --machines`. A machine file (`labs/cobra600.toml`) is TOML; every "
         "key\n"
         "has the default shown here, which is the Cobra 600's. `machine.kind` selects the sections that\n"
         "count; a key of another kind is refused.\n" +
         fields_markdown(machine_fields(defaults));
}

}  // namespace firn
