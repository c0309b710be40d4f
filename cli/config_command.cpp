// run_config checks, resolves, explains and documents the keys of experiments.
#include "cli/commands.h"

#include <fmt/core.h>

#include <cstdio>
#include <string>
#include <vector>

#include "cli/generated_document.h"
#include "cli/notify.h"
#include "cli/option_set.h"
#include "cli/user_config.h"
#include "config/error.h"
#include "config/fields.h"
#include "config/find_key.h"
#include "config/include.h"
#include "config/labs.h"
#include "config/machine.h"
#include "config/markdown.h"
#include "config/slice.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/labs/product.h"

namespace firn {
namespace {

enum class ConfigAction { kCheck, kDump, kFind, kExplain, kDocs, kUser, kNotify };

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

nlohmann::ordered_json as_json(Experiment experiment) {
  nlohmann::ordered_json out;
  for (const Field& f : fields(experiment))
    out[std::string(f.key)] = {{"value", value_text(f)}, {"unit", f.unit}};
  return out;
}

void write_out(const std::string& text) { std::fputs(text.c_str(), stdout); }

nlohmann::ordered_json as_json(const ConfigError& e) {
  return {{"file", e.file}, {"line", e.line}, {"key", e.key}, {"problem", e.problem}};
}

int show_user(const ConfigOptions& options) {
  const UserConfig user = read_user_config();
  const RunsFolder runs = default_runs_folder();
  if (options.json) {
    write_out(nlohmann::ordered_json{{"file", user.file.string()},
                                     {"runs", runs.folder},
                                     {"runs_named_by", runs.named_by},
                                     {"name", user.name},
                                     {"people", user.people.string()},
                                     {"notify", user.notify}}
                  .dump(2) +
              "\n");
    return kOk;
  }
  fmt::print("file    {}\nruns    {} ({})\nname    {}\nnotify  {}\n", user.file.string(), runs.folder,
             runs.named_by, user.name.empty() ? "(none)" : user.name,
             user.notify.empty() ? "(none)" : user.notify);
  return kOk;
}

// All mistakes of the keys; the inputs that they name are read when there are none.
int check_file(const Product& product, const ConfigOptions& options) {
  std::vector<ConfigError> mistakes;
  try {
    mistakes = mistakes_of(read_with_includes(options.file), options.overrides);
    if (mistakes.empty()) {
      const Experiment experiment = load_experiment(options.file, options.overrides);
      check_inputs(product, experiment,
                   make_inputs(product, experiment, std::filesystem::path(options.file).parent_path()));
    }
  } catch (const ConfigError& e) {
    mistakes.push_back(e);
  } catch (const UsageError& e) {
    mistakes.emplace_back(options.file, 0, "", e.what());
  }
  if (mistakes.empty()) {
    write_out(options.json ? nlohmann::ordered_json{{"ok", true}, {"file", options.file}}.dump(2) + "\n"
                           : options.file + ": ok\n");
    return kOk;
  }
  if (!options.json) {
    for (std::size_t n = 0; n + 1 < mistakes.size(); ++n)
      std::fprintf(stderr, "firn config check: %s\n", mistakes[n].what());
    throw ConfigError(mistakes.back());  // main writes the last one
  }
  nlohmann::ordered_json first = as_json(mistakes.front()), all = nlohmann::ordered_json::array();
  for (const ConfigError& e : mistakes) all.push_back(as_json(e));
  nlohmann::ordered_json out = {{"ok", false}};
  out.update(first);
  out["mistakes"] = all;
  write_out(out.dump(2) + "\n");
  return kUsage;
}

nlohmann::ordered_json as_json(const Field& f) {
  return {{"key", f.key},
          {"type", type_text(f)},
          {"unit", f.unit},
          {"allowed", limits_text(f)},
          {"default", value_text(f)},
          {"between_layers", f.between_layers},
          {"meaning", f.meaning}};
}

std::string explanation(const Field& f) {
  const std::string limits = limits_text(f), unit = f.unit.empty() ? "" : " " + std::string(f.unit);
  std::string text = f.key + " = " + value_text(f) + unit + "   " + std::string(type_text(f)) +
                     (limits.empty() ? "" : ", " + limits) + "\n    " + std::string(f.meaning) + "\n";
  if (f.between_layers) text += "    may change while a print runs: firn ctl RUN set " + f.key + "=...\n";
  std::string labs;
  for (const LabKind* lab : lab_kinds())
    if (belongs(f, lab->name)) labs += (labs.empty() ? "" : ", ") + std::string(lab->name);
  return text + "    labs: " + labs + "\n";
}

void show_fields(const std::vector<const Field*>& found, bool json, bool long_form) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Field* f : found)
    if (json)
      all.push_back(as_json(*f));
    else
      write_out(long_form
                    ? explanation(*f)
                    : f->key + " = " + value_text(*f) + (f->unit.empty() ? "" : " " + std::string(f->unit)) +
                          ": " + std::string(f->meaning) + "\n");
  if (json) write_out(all.dump(2) + "\n");
}

int find(const ConfigOptions& options) {
  std::string query;
  for (const std::string& w : options.words) query += w + " ";
  Experiment defaults;
  const std::vector<Field> table = fields(defaults);
  const auto found = find_fields(table, query);
  show_fields(found, options.json, false);
  if (found.empty()) std::fprintf(stderr, "firn config find: no key and no sentence has these words\n");
  return found.empty() ? kFailed : kOk;
}

int explain(const ConfigOptions& options) {
  Experiment defaults;
  const std::vector<Field> table = fields(defaults);
  const std::string& key = options.words.front();
  std::vector<const Field*> found;
  for (const Field& f : table)
    if (f.key == key || f.section() == key) found.push_back(&f);
  if (found.empty()) {
    const std::string near = likeliest_key(table, key);
    throw UsageError(
        key.substr(0, 100) + ": unknown key" +
        (near.empty() ? "; firn config find WORD searches them" : "; the nearest known one is " + near));
  }
  show_fields(found, options.json, true);
  return kOk;
}

int run_config(const Product& product, const ConfigOptions& options) {
  switch (options.action) {
    case ConfigAction::kCheck:
      return check_file(product, options);
    case ConfigAction::kDump: {
      const Experiment experiment = load_experiment(options.file, options.overrides);
      write_out(options.json ? as_json(experiment).dump(2) + "\n" : dump(experiment));
      return kOk;
    }
    case ConfigAction::kFind:
      return find(options);
    case ConfigAction::kExplain:
      return explain(options);
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
    case ConfigAction::kNotify: {
      const UserConfig user = read_user_config();
      if (user.notify.empty()) throw UsageError(user.file.string() + ": names no notify.command");
      const int status = try_notice(user.notify);
      fmt::print(stderr, "{}: exit code {}\n", user.notify, status);
      return status == 0 ? kOk : kFailed;
    }
    case ConfigAction::kUser:
      return show_user(options);
  }
  return kUsage;
}

}  // namespace

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
  with_file("check", "names every mistake of an experiment", ConfigAction::kCheck);
  with_file("dump", "every key of an experiment with its resolved value", ConfigAction::kDump);
  const auto with_words = [&](const char* name, const char* words, const char* summary, ConfigAction action) {
    OptionSet sub = options.subcommand(name, summary);
    auto& o = common(sub, action);
    sub.option(words, o.words, "words of keys or of their sentences").required();
  };
  with_words("find", "WORD", "keys whose name or sentence has all the words", ConfigAction::kFind);
  with_words("explain", "KEY", "one key or section: default, range, meaning, when it may change",
             ConfigAction::kExplain);
  OptionSet user = options.subcommand("user", "what holds for all your commands, and where it is set");
  common(user, ConfigAction::kUser);
  OptionSet notify = options.subcommand("notify", "tries the command that a print's end is told to");
  common(notify, ConfigAction::kNotify);
  OptionSet docs =
      options.subcommand("docs", "writes docs/configuration.md, docs/machines.md or docs/slice-settings.md");
  auto& o = common(docs, ConfigAction::kDocs);
  docs.flag("--machines", o.machines, "the keys of machine files");
  docs.flag("--slice", o.slice, "the settings of firn slice");
  docs.option("-o,--output", o.output, "file; - = stdout; default: the file in docs/");
  options.require_subcommand();
}

}  // namespace firn
