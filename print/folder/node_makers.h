// Holds the table of all nodes by name, for replay, the in-process lab runs and the drawing of the data flow.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "drivers/link/link_probe.h"
#include "runtime/node.h"

namespace firn {

struct NamedMaker {
  NodeId id;
  MakeNode make;
  drivers::LinkProbe (*probe)() =
      nullptr;  ///< of an instrument that is known at its port; jets: of their kinds
};
/// Returns the nodes of this program: all, or those of its own table (print/CMakeLists.txt).
std::span<const NamedMaker> node_makers();

/// Returns the nodes of an experiment, in the table's order: jet_b only with two jets, droplet_estimator only
/// if the experiment asks for it. @throws UsageError naming a node that this program does not have
std::vector<NamedMaker> taking_part(const Experiment& experiment);
/// Returns the nodes of a recorded run, from the configuration in its record; if the configuration cannot be
/// read, by the files that exist.
std::vector<NamedMaker> taking_part(const std::filesystem::path& run);

/// Maps a channel to the names of the nodes that subscribe to it, from the nodes themselves, built from the
/// default experiment.
using Subscriptions = std::map<std::string, std::set<std::string>>;
Subscriptions all_subscriptions();

}  // namespace firn
