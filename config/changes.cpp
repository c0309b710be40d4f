#include "config/changes.h"

#include <algorithm>
#include <vector>

#include "config/error.h"
#include "config/fields.h"
#include "config/reader.h"
#include "core/control/controller.h"

namespace firn {
namespace {

Experiment changed(Experiment experiment, const std::string& key, const std::string& value) {
  read_fields(fields(experiment), "", "", {key + "=" + value});
  return experiment;
}

}  // namespace

// A scheme of droplets reads the section of its name; the schemes of the ice lab share the gains of smf.
std::string unread_by_scheme(const Experiment& experiment, std::string_view key) {
  const std::string& scheme = experiment.control.scheme;
  if (scheme == "auto" && key == "control.smf.ki_star") return "is 0 in scheme auto";
  for (const auto& s : control::schemes()) {
    if (!key.starts_with("control." + std::string(s.name) + ".") || s.name == scheme) continue;
    if (s.name == "smf" && scheme.starts_with("smf")) continue;
    if (scheme == "auto" && (s.name == "smf" || s.name == "mpc" || s.name == "threshold")) continue;
    return "is of scheme " + std::string(s.name) + ", and this print has scheme " + scheme;
  }
  if (key == "control.target_offset_mm" &&
      (scheme == "open_loop" || scheme == "pattern" || scheme == "registration"))
    return "is of schemes with feedback, and this print has scheme " + scheme;
  if (key.starts_with("control.foresee.") && scheme != "smf_foresee")
    return "is of scheme smf_foresee, and this print has scheme " + scheme;
  return "";
}

std::string changeable_keys(const Experiment& experiment) {
  std::string keys;
  Experiment e = experiment;
  for (const Field& f : fields(e))
    if (f.between_layers && belongs(f, e)) keys += (keys.empty() ? "" : ", ") + f.key;
  return keys;
}

std::string change_problem(const Experiment& experiment, const std::string& key, const std::string& value) {
  Experiment e = experiment;
  const std::vector<Field> all = fields(e);
  const auto field = std::ranges::find(all, key, &Field::key);
  if (field == all.end() || !field->between_layers || !belongs(*field, e))
    return (field == all.end() ? key.substr(0, 100) + ": unknown key"
                               : key + ": cannot change while a print runs") +
           "; these can: " + changeable_keys(experiment);
  if (const std::string unread = unread_by_scheme(experiment, key); !unread.empty())
    return key + ": " + unread;
  try {
    changed(experiment, key, value);
  } catch (const ConfigError& error) {
    return error.problem;
  }
  return "";
}

std::string Changes::set(const std::string& key, const std::string& value) {
  std::string problem = change_problem(experiment_, key, value);
  if (problem.empty()) experiment_ = changed(experiment_, key, value);
  return problem;
}

}  // namespace firn
