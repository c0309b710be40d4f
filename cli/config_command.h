// run_config checks, resolves, explains and documents the keys of experiments.
#pragma once

#include <string>
#include <vector>

namespace firn {

class OptionSet;

enum class ConfigAction { kCheck, kDump, kFind, kExplain, kDocs };

struct ConfigOptions {
  ConfigAction action = ConfigAction::kCheck;
  std::string file;
  std::vector<std::string> overrides;  ///< "a.b=value"
  std::vector<std::string> words;      ///< of kFind; the key of kExplain
  std::string output;                  ///< of kDocs; "-" = stdout; empty = the file in docs/
  bool machines = false;               ///< of kDocs: the keys of machine files
  bool slice = false;                  ///< of kDocs: the settings of firn slice
  bool json = false;
};

int run_config(const ConfigOptions& options);

/// Declares the arguments.
void declare_config(OptionSet& options);

}  // namespace firn
