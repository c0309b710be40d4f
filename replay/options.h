// ReplayOptions holds the choices of replay's caller: nodes, tolerance, ignored fields, changed
// configuration.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/node.h"

namespace firn::replay {

struct NodeMaker {
  std::string_view name;
  MakeNode make = MakeNode::Function{};
};

/// Holds a field that may differ, and the reason.
struct Ignore {
  std::string field;  ///< "LAYER_PLAN.iterations", or "iterations" on every channel; no array indices
  std::string reason;
};
/// Reads "FIELD=reason". @throws std::invalid_argument if either is empty.
Ignore parse_ignore(const std::string& text);

/// Code of the run itself, as a controller in Python, may be replayed.
enum class RunPython {
  kOwn,    ///< of a run that this user on this host printed (runs/folder/origin.h)
  kNever,  ///< of no run
  kAlways  ///< of any run
};

struct ReplayOptions {
  std::span<const NodeMaker> makers;  ///< of all nodes to replay
  std::string only_node;              ///< empty = all
  double tolerance = 0.0;             ///< numeric fields that differ by no more are equal
  std::vector<Ignore> ignores;
  /// Returns the configuration to build a node from, given the recorded one; empty = as recorded.
  std::function<std::string(const std::string& recorded_toml)> change_config;
  RunPython run_python = RunPython::kOwn;
  std::string commit;      ///< of this program; empty = not compared
  std::string platform;    ///< as WalHead::platform; empty = not compared
  int threads = 0;         ///< 0 = as many as the machine has
  bool stopwatch = false;  ///< fills NodeVerdict::handler_ns
};

}  // namespace firn::replay
