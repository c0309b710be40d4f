// firn config check|dump FILE, firn config docs.
#pragma once

#include <string>
#include <vector>

namespace firn {

enum class ConfigAction { kCheck, kDump, kDocs };

struct ConfigOptions {
  ConfigAction action = ConfigAction::kCheck;
  std::string file;
  std::vector<std::string> overrides;              ///< "a.b=value"
  std::string output = "docs/configuration.md";    ///< of kDocs; "-" = stdout
  bool json = false;
};

int run_config(const ConfigOptions& options);

}  // namespace firn
