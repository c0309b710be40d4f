#include "config/field_texts.h"
#include "config/markdown.h"

namespace firn {

namespace {

bool is_empty(const Field& f) {
  if (const auto* const text = std::get_if<std::string*>(&f.value)) return (*text)->empty();
  const auto* const number = std::get_if<double*>(&f.value);
  return number && **number == 0.0;
}

}  // namespace

std::string dump(const Experiment& experiment) {
  Experiment copy = experiment;
  std::vector<Field> table = fields(copy);
  std::erase_if(table,
                [&](const Field& f) { return !belongs(f, experiment) || (f.only_if_given && is_empty(f)); });
  return fields_toml(table);
}

std::vector<ConfigDifference> differences(const Experiment& a, const Experiment& b) {
  Experiment copy_a = a, copy_b = b;
  for (const auto& [host, _] : a.hosts.address) copy_b.hosts.address.try_emplace(host);
  for (const auto& [host, _] : b.hosts.address) copy_a.hosts.address.try_emplace(host);
  for (const auto& [name, _] : a.own_programs) copy_b.own_programs.try_emplace(name);
  for (const auto& [name, _] : b.own_programs) copy_a.own_programs.try_emplace(name);
  const std::vector<Field> fields_a = fields(copy_a), fields_b = fields(copy_b);
  std::vector<ConfigDifference> out;
  for (std::size_t n = 0; n < fields_a.size(); ++n) {
    const std::string text_a = value_text(fields_a[n]), text_b = value_text(fields_b[n]);
    if (text_a != text_b) out.push_back({std::string(fields_a[n].key), text_a, text_b});
  }
  return out;
}

std::string configuration_markdown() {
  Experiment defaults;
  std::vector<Field> table =
      fields(defaults);  // without what one scheme or physics alone has: config explain
  std::erase_if(table, [](const Field& f) { return !f.scheme.empty() || !f.nature.empty(); });
  return "# Configuration\n\n"
         "Written by `firn config docs`. An experiment is a TOML file; every key has the default shown "
         "here.\n"
         "`include = \"../labs/inkjet-lu2015.toml\"` reads a lab's keys first; `--set KEY=VALUE` comes "
         "last.\n"
         "`firn config check FILE` reports every mistake with file, line, key and limit; `firn config "
         "dump\n"
         "FILE` writes every key with its resolved value. Keys of the other kind of lab are refused: `[lab]\n"
         "kind = \"inkjet\"` has no [ice], [robot], [valve_a], [valve_b], [laser_point], [heater], [flow],\n"
         "[plant.ice]; `\"ice\"` takes its part, grid and process from them.\n\n"
         "`[meta]` says what is printed: operator, project, sample, substrate, ink, batch, and keys of your "
         "own\n"
         "(letters a to z, digits, '_'). Values are texts, numbers, true or false, and dates. A lab file "
         "declares\n"
         "types and required keys in `[lab.meta]`: `batch = {type = \"text\", required = true, one_of = "
         "[...],\n"
         "meaning = \"...\"}`; types are text, number, integer, boolean and date. `run.name` may hold "
         "`{meta.KEY}`. `[lab.use]` of a lab file limits what a batch and an instrument give: `batch_mm3 = "
         "50000`, `lamp_h = 1000`, `warn_percent = 90` ([firn runs use](commands/runs.md#use)).\n"
         "No node reads `[meta]`, so that it changes no byte of a print. How it is used: "
         "[print](commands/print.md#what-is-printed).\n" +
         fields_markdown(table);
}

}  // namespace firn
