// taking_part lists the nodes of an experiment or of a recorded run.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/labs/product.h"

namespace firn {

/// Returns the nodes of an experiment, in the product's order: jet_b only with two jets, droplet_estimator
/// only if the experiment asks for it. @throws UsageError naming a node that this program does not have
std::vector<NamedMaker> taking_part(const Product& product, const Experiment& experiment);
/// Returns the nodes of a recorded run, from the configuration in its record; if the configuration cannot be
/// read, by the files that exist.
std::vector<NamedMaker> taking_part(const Product& product, const std::filesystem::path& run);

/// Maps a channel to the names of the nodes that subscribe to it, from the nodes themselves, built from each
/// lab's fullest experiment.
using Subscriptions = std::map<std::string, std::set<std::string>>;
Subscriptions all_subscriptions(const Product& product);

}  // namespace firn
