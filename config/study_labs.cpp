#include "config/study_labs.h"

#include <algorithm>

#include "config/checks.h"
#include "config/error.h"
#include "config/fields.h"
#include "config/reader.h"

namespace firn {
namespace {

void set_lab(const Study& study, const std::vector<KeyRange>& priors, const std::vector<std::string>& lab,
             const std::string& whose, Experiment& e) try {
  read_fields(fields(e), "", "", lab);
  check_experiment(e, {}, "", true);
} catch (const ConfigError& error) {
  const auto prior = std::ranges::find(priors, error.key, &KeyRange::key);
  throw ConfigError(study.worlds.file.empty() ? study.file : study.worlds.file,
                    prior == priors.end() ? 0 : prior->line, error.key,
                    "[prior], " + whose + ": " + error.problem);
}

}  // namespace

std::vector<KeyRange> priors_of(const Study& study, std::size_t part) {
  std::vector<KeyRange> all = study.priors;
  const std::vector<KeyRange>& own = study.parts[part].priors;
  all.insert(all.end(), own.begin(), own.end());
  return all;
}

std::vector<std::string> drawn_lab(const Study& study, std::size_t part, std::uint64_t seed) {
  std::vector<std::string> drawn;
  for (const KeyRange& prior : priors_of(study, part)) drawn.push_back(prior.drawn(seed));
  return drawn;
}

void draw_lab(const Study& study, std::size_t part, std::uint64_t seed, Experiment& e) {
  const std::vector<KeyRange> priors = priors_of(study, part);
  if (!priors.empty())
    set_lab(study, priors, drawn_lab(study, part, seed), "seed " + std::to_string(seed), e);
}

void check_labs(const Study& study, std::size_t part, const Experiment& experiment) {
  Experiment e = experiment;
  const std::vector<Field> all = fields(e);
  const std::vector<KeyRange> priors = priors_of(study, part);
  std::vector<std::string> low, high;
  for (const KeyRange& prior : priors) {
    const auto field = std::ranges::find(all, prior.key, &Field::key);
    if (field != all.end() && !belongs(*field, e))
      throw ConfigError(study.worlds.file.empty() ? study.file : study.worlds.file, prior.line, prior.key,
                        "[prior], " + prior.key + ": no key of this experiment");
    low.push_back(prior.lowest());
    high.push_back(prior.highest());
  }
  if (priors.empty()) return;
  set_lab(study, priors, low, "lowest values", e);
  set_lab(study, priors, high, "highest values", e);
}

void take_seeds(Study& study, std::size_t count) {
  if (study.worlds.file.empty()) {
    study.seeds.clear();
    for (std::uint64_t s = 1; s <= count; ++s) study.seeds.push_back(s);
    return;
  }
  if (count > study.seeds.size())
    throw ConfigError(study.file, 0, "seeds",
                      "seeds: " + std::to_string(count) + " are asked for, and " + study.worlds.file +
                          " declares " + std::to_string(study.seeds.size()) + " labs of this kind");
  study.seeds.resize(count);
}

void take_worlds(Study& study, const std::filesystem::path& folder) {
  const std::filesystem::path file = (folder / study.worlds.file).lexically_normal();
  const WorldList declared = load_worlds(file);
  const auto use = std::size_t(study.worlds.use);
  study.worlds.name = declared.name;
  study.worlds.goals = declared.goals;
  if (!declared.experiment.empty())
    study.experiment = (std::filesystem::path(study.worlds.file).parent_path() / declared.experiment)
                           .lexically_normal()
                           .string();
  study.overrides.insert(study.overrides.begin(), declared.overrides.begin(), declared.overrides.end());
  study.metrics = declared.metrics;
  study.parts.clear();
  for (const DeclaredWorld& w : declared.worlds)
    if (!w.priors[use].empty())
      study.parts.push_back({w.name, w.overrides, w.line, {}, w.priors[use], w.source});
  if (study.parts.empty())
    throw ConfigError(file.string(), 0, "world",
                      "world: none has " + std::string(kLabSetWords[use]) + " labs");
  const std::size_t asked = study.seeds.size();
  study.seeds = declared.seeds[use];
  if (asked > 0) take_seeds(study, asked);
}

}  // namespace firn
