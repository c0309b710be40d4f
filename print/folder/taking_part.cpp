#include "print/folder/taking_part.h"

#include <algorithm>

#include "config/labs.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "runs/folder/config_change.h"

namespace firn {

std::vector<NamedMaker> taking_part(const Product& product, const Experiment& e) {
  std::vector<NamedMaker> out;
  for (const NamedMaker& m : product.nodes)
    if (takes_part(e, info(m.id).name)) out.push_back(m);
  for (const LabProcess& p : lab_of(e).processes)
    if (takes_part(e, p.node) &&
        std::ranges::none_of(out, [&](const NamedMaker& m) { return info(m.id).name == p.node; }))
      throw UsageError(std::string(p.node) + ": this program does not have the node; firn print has all");
  return out;
}

std::vector<NamedMaker> taking_part(const Product& product, const std::filesystem::path& run) {
  try {
    return taking_part(product, parse_experiment(runs::recorded_config(run), "the recorded configuration"));
  } catch (const std::exception&) {  // replay reports the fault
    std::vector<NamedMaker> out = taking_part(product, Experiment{});
    for (const NamedMaker& m : product.nodes)
      if (!takes_part(Experiment{}, info(m.id).name) &&
          std::filesystem::exists(RunPaths(run).wal_path(info(m.id).name)))
        out.push_back(m);
    return out;
  }
}

namespace {

void add_subscriptions(const Product& product, const Experiment& e, const Blobs& inputs, Subscriptions& out) {
  const std::string config = dump(e);
  for (const NamedMaker& maker : product.nodes) {
    if (!takes_part(e, info(maker.id).name) && maker.id != NodeId::kJetB) continue;
    const std::unique_ptr<Node> node = maker.make(config, inputs);
    for (const Node::Route& route : node->routes())
      out[std::string(route.channel)].emplace(info(maker.id).name);
  }
}

}  // namespace

Subscriptions all_subscriptions(const Product& product) {
  Subscriptions out;
  for (const PrintLab* lab : product.labs) {
    const Experiment e = lab->fullest();
    add_subscriptions(product, e, lab->example_inputs(e), out);
  }
  return out;
}

}  // namespace firn
