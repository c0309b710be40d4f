#include <algorithm>

#include "config/labs.h"
#include "files/usage_error.h"
#include "print/folder/node_makers.h"
#include "print/folder/run_config.h"

namespace firn {

std::vector<NamedMaker> taking_part(const Experiment& e) {
  std::vector<NamedMaker> out;
  for (const NamedMaker& m : node_makers())
    if (takes_part(e, info(m.id).name)) out.push_back(m);
  for (const LabProcess& p : lab_of(e).processes)
    if (takes_part(e, p.node) &&
        std::ranges::none_of(out, [&](const NamedMaker& m) { return info(m.id).name == p.node; }))
      throw UsageError(std::string(p.node) + ": this program does not have the node; firn print has all");
  return out;
}

std::vector<NamedMaker> taking_part(const std::filesystem::path& run) {
  try {
    return taking_part(parse_experiment(recorded_config(run), "the recorded configuration"));
  } catch (const std::exception&) {  // replay reports the fault
    std::vector<NamedMaker> out = taking_part(Experiment{});
    for (const NamedMaker& m : node_makers())
      if (!takes_part(Experiment{}, info(m.id).name) &&
          std::filesystem::exists(run / "nodes" / (std::string(info(m.id).name) + ".wal")))
        out.push_back(m);
    return out;
  }
}

}  // namespace firn
