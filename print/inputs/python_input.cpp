#include "print/inputs/python_input.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "config/error.h"
#include "core/control/python_scheme.h"
#include "files/digest.h"
#include "plant/inkjet/model.h"
#include "plant/world/setup.h"
#include "procs/controller/python_controller.h"
#include "procs/droplet_estimator/node.h"
#include "python/host/load.h"

namespace firn {
namespace {

Blob text_blob(std::string role, std::string_view text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  std::vector<std::byte> bytes(begin, begin + text.size());
  std::string digest = sha256_hex(bytes);
  return {std::move(role), std::move(digest), std::move(bytes)};
}

std::string in_a_line(std::string lines) {
  while (lines.ends_with('\n')) lines.pop_back();
  for (std::size_t at = 0; (at = lines.find('\n', at)) != lines.npos;) lines.replace(at, 1, ", ");
  return lines;
}

// Versions by name, of the texts' lines "numpy 1.24.2".
std::map<std::string, std::string> by_name(const std::string& lines) {
  std::map<std::string, std::string> versions;
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);)
    versions[line.substr(0, line.find(' '))] = line.substr(std::min(line.size(), line.find(' ')));
  return versions;
}

// A package that is not loaded here is not needed here: a replay runs no world.
bool same_versions(const std::string& now, const std::string& then) {
  const auto recorded = by_name(then);
  return std::ranges::all_of(by_name(now), [&](const auto& one) {
    const auto at = recorded.find(one.first);
    return at == recorded.end() || at->second == one.second;
  });
}

}  // namespace

std::string python_difference(const Blobs& inputs) {
  const auto recorded = std::ranges::find(inputs, kPythonVersionsRole, &Blob::role);
  if (recorded == inputs.end()) return "";
  const std::string then(reinterpret_cast<const char*>(recorded->bytes.data()), recorded->bytes.size());
  const std::string now = python::host().versions();
  return same_versions(now, then) ? "" : in_a_line(now) + " here; the run has " + in_a_line(then);
}

namespace {

// Reads the files of one class, and builds it from them as the print will.
void add_class(const char* key, const std::string& text, std::string_view role,
               const std::filesystem::path& folder, const std::function<void(const Blobs&)>& make,
               Blobs& inputs) {
  if (!control::is_python_scheme(text)) return;
  const std::string file = (folder / control::parse_python_scheme(text).file).string();
  try {
    for (const python::SourceFile& source : python::host().sources(file))
      inputs.push_back(text_blob(std::string(role) + source.name, source.text));
    make(inputs);
  } catch (const std::runtime_error& error) {
    throw ConfigError(key, 0, key, error.what());
  }
}

}  // namespace

void add_python_inputs(const Experiment& e, const std::filesystem::path& folder, const Mask& mask,
                       const std::function<void(const Blobs&)>& make_controller, Blobs& inputs) {
  const std::size_t before = inputs.size();
  add_class("control.scheme", e.control.scheme, python::kControllerRole, folder, make_controller, inputs);
  add_class(
      "estimator.droplets", e.estimator.droplets, python::kEstimatorRole, folder,
      [&](const Blobs& blobs) { DropletEstimatorNode(e, mask, blobs); }, inputs);
  add_class(
      "plant.model", e.plant.model, python::kPlantRole, folder,
      [&](const Blobs& blobs) { plant::make_model(plant::world_config(e, blobs)); }, inputs);
  if (inputs.size() > before)
    inputs.push_back(text_blob(std::string(kPythonVersionsRole), python::host().versions()));
}

}  // namespace firn
