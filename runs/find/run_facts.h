// RunFacts holds the values of one run by which it is found and listed: its documents, [meta], tags, notes
// and settings.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runs/folder/list.h"

namespace firn::runs {

/// A value under a key; a key may have several, as "tag".
struct Fact {
  std::string key;
  std::optional<double> number;  ///< of a quantity
  std::string word;              ///< the value as text
};

struct RunFacts {
  std::vector<Fact> facts;
  std::string text;       ///< in which a word is looked for
  bool settings = false;  ///< the experiment was read: a setting without a fact has its default
  std::string lab;
  std::string started_utc;
  bool ended = false;  ///< there is a result.json
};

/// A key that every run may have, in words for the documentation.
struct FactKey {
  std::string_view key, meaning;
};
/// Returns the keys that a condition may name beside meta.KEY and the keys of experiments.
std::vector<FactKey> fact_keys();

/// Reads a run as firn runs lists it. @param settings the experiment is read too, which takes a millisecond
RunFacts run_facts(const RunEntry& entry, bool settings);

/// Returns a run as an object of firn runs --json, without its "run" and "address".
std::string run_listing_text(const RunEntry& entry);

}  // namespace firn::runs
