#include "cli/config_command.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/generated_document.h"
#include "cli/option_set.h"
#include "config/error.h"
#include "config/fields.h"
#include "config/include.h"
#include "config/machine.h"
#include "config/markdown.h"
#include "config/slice.h"
#include "print/exit_codes.h"
#include "print/labs/print_labs.h"

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

void declare_config(OptionSet& options) {
  const auto common = [](OptionSet& sub, ConfigAction action) -> ConfigOptions& {
    auto& o = sub.calls(run_config);
    o.action = action;
    sub.json_flag(o.json);
    return o;
  };
  const auto with_file = [&](const char* name, const char* summary, ConfigAction action) {
    OptionSet sub = options.subcommand(name, summary);
    auto& o = common(sub, action);
    sub.option("FILE", o.file, "experiment").required();
    sub.override_option(o.overrides);
  };
  with_file("check", "names the first mistake of an experiment", ConfigAction::kCheck);
  with_file("dump", "every key of an experiment with its resolved value", ConfigAction::kDump);
  OptionSet docs =
      options.subcommand("docs", "writes docs/configuration.md, docs/machines.md or docs/slice-settings.md");
  auto& o = common(docs, ConfigAction::kDocs);
  docs.flag("--machines", o.machines, "the keys of machine files");
  docs.flag("--slice", o.slice, "the settings of firn slice");
  docs.option("-o,--output", o.output, "file; - = stdout; default: the file in docs/");
  options.require_subcommand();
}

}  // namespace firn
