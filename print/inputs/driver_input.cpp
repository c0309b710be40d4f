#include "print/inputs/driver_input.h"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "config/device_kinds.h"
#include "config/error.h"
#include "core/control/python_scheme.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/inputs/targets.h"
#include "runtime/python_port.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

bool is_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

std::string_view take_name(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  const auto end = std::ranges::find_if_not(text, is_name);
  const std::string_view name = text.substr(0, std::size_t(end - text.begin()));
  text.remove_prefix(name.size());
  return name;
}

/// The first parts of the names that a line imports: "import a.b, c as d" has a and c.
std::vector<std::string> imported_by(std::string_view line) {
  std::vector<std::string> names;
  const std::string_view word = take_name(line);
  if (word == "from") names.emplace_back(take_name(line));
  if (word != "import") return names;
  while (true) {
    names.emplace_back(take_name(line));
    const std::size_t comma = line.find(',');
    if (comma == line.npos) return names;
    line.remove_prefix(comma + 1);
  }
}

std::vector<std::byte> bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<std::pair<std::string, std::string>> driver_modules(const Experiment& e, const std::string& node,
                                                                const fs::path& folder) {
  std::vector<std::pair<std::string, std::string>> modules;
  if (!is_python_driver(e, node)) return modules;
  const fs::path own = folder / control::parse_python_scheme(device_kind(e, node)).file;
  modules.emplace_back(own.filename().string(), own.string());
  for (std::size_t n = 0; n < modules.size(); ++n) {
    std::string text;
    try {
      text = read_file(modules[n].second);
    } catch (const UsageError& error) {
      const std::string key = "devices." + node + ".kind";
      throw ConfigError(key, 0, key, error.what());
    }
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      for (const std::string& name : imported_by(line)) {
        const fs::path path = own.parent_path() / (name + ".py");
        std::error_code error;
        const bool known =
            std::ranges::any_of(modules, [&](const auto& m) { return m.first == name + ".py"; });
        if (!name.empty() && !known && fs::is_regular_file(path, error))
          modules.emplace_back(name + ".py", path.string());
      }
  }
  return modules;
}

std::map<std::string, PortAddress> with_driver_files(std::map<std::string, PortAddress> ports,
                                                     const Experiment& e, const fs::path& folder) {
  for (auto& [node, address] : ports) address.driver_files = driver_modules(e, node, folder);
  return ports;
}

void add_driver_inputs(const Experiment& e, const fs::path& folder, Blobs& inputs) {
  for (const DevicePort& port : kDevicePorts) {
    const std::string node(port.node);
    if (!takes_part(e, node)) continue;
    for (const auto& [name, path] : driver_modules(e, node, folder))
      inputs.push_back(make_blob(driver_role(node) + name, bytes_of(read_file(path))));
  }
}

}  // namespace firn
