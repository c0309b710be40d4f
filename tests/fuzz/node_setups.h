// NodeSetup holds what builds one node of a recorded run, for fuzz targets of nodes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "runs/folder/run_folder.h"
#include "runtime/wal_file.h"

namespace firn::fuzz {

struct RecordedRun {
  std::filesystem::path folder;
  std::string config_toml;  ///< without what is the default, which takes the most time to read
  Blobs inputs;
  std::int64_t run_id = 0;
};
struct NodeSetup {
  NodeId id;
  MakeNode make;
  std::shared_ptr<const RecordedRun> run;
};

inline std::string without_defaults(const std::string& toml) {
  const std::string usual = "\n" + dump(Experiment{}) + "\n";
  std::string out;
  for (std::size_t at = 0; at < toml.size();) {
    const std::size_t end = std::min(toml.find('\n', at), toml.size());
    const std::string line = toml.substr(at, end - at);
    if (line.starts_with("[") || usual.find("\n" + line + "\n") == usual.npos) out += line + "\n";
    at = end + 1;
  }
  return out;
}

inline std::vector<NodeSetup> node_setups() {
  std::vector<NodeSetup> setups;
  for (const char* name : {"v5-two-inks", "v5-ice"}) {
    const std::filesystem::path folder =
        std::filesystem::path(FIRN_SOURCE_DIR) / "tests/replay/golden" / name;
    const runs::RunFolder run = runs::RunFolder::open(folder);
    const auto recorded = std::make_shared<const RecordedRun>(
        RecordedRun{folder, without_defaults(run.experiment_toml()), run.inputs(), run.run_id()});
    for (const NamedMaker& m : taking_part(full_product(), parse_experiment(run.experiment_toml(), name)))
      setups.push_back({m.id, m.make, recorded});
  }
  return setups;
}

}  // namespace firn::fuzz
