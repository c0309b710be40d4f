// Every node of the house, by name: what replay rebuilds, the in-process lab runs and the data flow is drawn
// from.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "runtime/node.h"

namespace firn {

struct NamedMaker {
  NodeId id;
  MakeNode make;
};
std::span<const NamedMaker> node_makers();

/// Those that an experiment has, in the table's order: jet_b only with two jets,
/// droplet_estimator only where it is asked for.
std::vector<NamedMaker> taking_part(const Experiment& experiment);
/// The same for a recorded run, from the configuration that it kept; when it cannot be read, by the
/// files that are there.
std::vector<NamedMaker> taking_part(const std::filesystem::path& run);

/// Channel -> names of the nodes that subscribe to it, from the nodes themselves, built from the default
/// experiment.
using Subscriptions = std::map<std::string, std::set<std::string>>;
Subscriptions all_subscriptions();

}  // namespace firn
