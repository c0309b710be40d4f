#include "cli/config_command.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/generated_document.h"
#include "config/error.h"
#include "config/fields.h"
#include "config/include.h"
#include "config/machine.h"
#include "config/markdown.h"
#include "config/slice.h"
#include "print/exit_codes.h"
#include "print/inputs/targets.h"

namespace firn {
namespace {

nlohmann::ordered_json as_json(Experiment experiment) {
  nlohmann::ordered_json out;
  for (const Field& f : fields(experiment))
    out[std::string(f.key)] = {{"value", value_text(f)}, {"unit", f.unit}};
  return out;
}

void print(const std::string& text) { std::fputs(text.c_str(), stdout); }

int check(const ConfigOptions& options) {
  try {
    const Experiment experiment = load_experiment(options.file, options.overrides);
    make_inputs(experiment, std::filesystem::path(options.file).parent_path());
  } catch (const ConfigError& e) {
    if (!options.json) throw;
    print(nlohmann::ordered_json{
              {"ok", false}, {"file", e.file}, {"line", e.line}, {"key", e.key}, {"problem", e.problem}}
              .dump(2) +
          "\n");
    return kUsage;
  }
  print(options.json ? nlohmann::ordered_json{{"ok", true}, {"file", options.file}}.dump(2) + "\n"
                     : options.file + ": ok\n");
  return kOk;
}

}  // namespace

int run_config(const ConfigOptions& options) {
  switch (options.action) {
    case ConfigAction::kCheck:
      return check(options);
    case ConfigAction::kDump: {
      const Experiment experiment = load_experiment(options.file, options.overrides);
      print(options.json ? as_json(experiment).dump(2) + "\n" : dump(experiment));
      return kOk;
    }
    case ConfigAction::kDocs:
      write_generated(!options.output.empty() ? options.output
                      : options.machines      ? "docs/machines.md"
                      : options.slice         ? "docs/slice-settings.md"
                                              : "docs/configuration.md",
                      options.machines ? machine_markdown()
                      : options.slice  ? slice_markdown()
                                       : configuration_markdown(),
                      options.json);
      return kOk;
  }
  return kUsage;
}

}  // namespace firn
