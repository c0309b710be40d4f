#include "print/inputs/python_input.h"

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "config/error.h"
#include "core/control/python_scheme.h"
#include "files/digest.h"
#include "procs/controller/node.h"
#include "procs/controller/python_controller.h"
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

}  // namespace

std::string python_difference(const Blobs& inputs) {
  const auto recorded = std::ranges::find(inputs, kPythonVersionsRole, &Blob::role);
  if (recorded == inputs.end()) return "";
  const std::string then(reinterpret_cast<const char*>(recorded->bytes.data()), recorded->bytes.size());
  const std::string now = python::host().versions();
  return now == then ? "" : in_a_line(now) + " here; the run has " + in_a_line(then);
}

void add_python_inputs(const Experiment& e, const control::Setup& setup, const std::filesystem::path& folder,
                       Blobs& inputs) {
  if (!control::is_python_scheme(e.control.scheme)) return;
  const std::string file = (folder / control::parse_python_scheme(e.control.scheme).file).string();
  try {
    for (const python::SourceFile& source : python::host().sources(file))
      inputs.push_back(text_blob(std::string(kPythonRole) + source.name, source.text));
    make_python_controller(setup, control_options(e), inputs);
    inputs.push_back(text_blob(std::string(kPythonVersionsRole), python::host().versions()));
  } catch (const std::runtime_error& error) {
    throw ConfigError("control.scheme", 0, "control.scheme", error.what());
  }
}

}  // namespace firn
