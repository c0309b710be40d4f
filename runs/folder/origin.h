// run_origin ties a run to the user and the host that printed it, so that its Python code can be told from a
// stranger's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace firn::runs {

/// Role and SHA-256 of an input.
using InputDigests = std::vector<std::pair<std::string, std::string>>;

/// Returns the digest that provenance.json has as `origin`: SHA-256 of the secret number of the machine
/// (/etc/machine-id, else the boot's), the user and all that decides what code runs. Another host cannot
/// compute it, and another configuration or input has another one; the order of the inputs is none of it.
std::string run_origin(std::int64_t run_id, const std::string& config_toml, const InputDigests& inputs);

/// Returns true if this user on this host printed `run` with this configuration and these inputs, and owns
/// the folder.
bool is_own_run(const std::filesystem::path& run, std::int64_t run_id, const std::string& config_toml,
                const InputDigests& inputs);

/// Returns the Python texts of a configuration that a node would run: "control.scheme =
/// python:level.py:Level" for the controller. Empty: none.
/// @param node empty: of any node, and of the simulated world
std::string python_of(const std::string& config_toml, const std::string& node);

/// Refuses to print a run on, or again, whose Python code is not this user's.
/// @param run_python the user wants it
/// @throws UsageError naming the code and --run-python
void require_own_python(const std::filesystem::path& run, bool run_python);

/// Refuses to go on with a run that would run a stranger's Python or commands, or reach a stranger's hosts.
/// @throws UsageError naming them and --run-python
void require_own_resume(const std::filesystem::path& run, bool run_python);

}  // namespace firn::runs
