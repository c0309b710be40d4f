// firn config check|dump FILE, firn config docs.
#pragma once

#include <string>
#include <vector>

namespace firn {

enum class ConfigAction { kCheck, kDump, kDocs };

struct ConfigOptions {
  ConfigAction action = ConfigAction::kCheck;
  std::string file;
  std::vector<std::string> overrides;  ///< "a.b=value"
  std::string output;                  ///< of kDocs; "-" = stdout; empty = the file in docs/
  bool machines = false;               ///< of kDocs: the keys of machine files
  bool slice = false;                  ///< of kDocs: the settings of firn slice
  bool json = false;
};

int run_config(const ConfigOptions& options);

}  // namespace firn
