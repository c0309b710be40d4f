// Every node of the house, by name: what replay rebuilds, the in-process lab runs and the data flow is drawn from.
#pragma once

#include <map>
#include <set>
#include <span>
#include <string>

#include "runtime/node.h"

namespace firn {

struct NamedMaker {
  NodeId id;
  MakeNode make;
};
std::span<const NamedMaker> node_makers();

/// Channel -> names of the nodes that subscribe to it, from the nodes themselves, built from the default experiment.
using Subscriptions = std::map<std::string, std::set<std::string>>;
Subscriptions all_subscriptions();

}  // namespace firn
