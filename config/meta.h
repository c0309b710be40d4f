// Meta holds the facts about a print that people search for: [meta] of an experiment, with operator, project,
// sample, substrate, ink, batch and keys of the user's own. Nodes never see it: a run keeps it in
// provenance.json, beside their configuration.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace firn {

using MetaValue = std::variant<std::string, double, std::int64_t, bool>;

struct MetaEntry {
  std::string key;
  MetaValue value;

  bool operator==(const MetaEntry&) const = default;
};
using Meta = std::vector<MetaEntry>;  ///< in the order of the keys

inline constexpr std::size_t kMaxMetaKeys = 64, kMaxMetaKeyBytes = 40, kMaxMetaTextBytes = 500;

/// A key that the lab requires and that nobody gave.
struct MissingMeta {
  std::string key, meaning;
  std::string file;  ///< that requires it
  int line = 0;
};

/// A limit of [lab.use] that use is compared with.
struct UseLimit {
  std::string key;  ///< "batch_mm3", "lamp_h": the instrument and its hours
  double limit = 0.0;
};
struct UseLimits {
  std::vector<UseLimit> limits;  ///< in the order of the keys
  double warn_percent = 90.0;    ///< of a limit, from which on a print warns
};

struct PrintMeta {
  Meta values;
  std::vector<MissingMeta> missing;
  UseLimits use = {};
};

/// Keys that every lab knows. All are texts; a lab may declare another type.
std::vector<std::string_view> known_meta_keys();

/// Returns true for letters from a to z, digits and '_', beginning with a letter.
bool is_meta_key(std::string_view key);

/// Returns the value without quotes: "PCB-7", "41.5", "true".
std::string meta_value_text(const MetaValue& value);
/// Returns the section [meta] as TOML; empty without entries.
std::string meta_toml(const Meta& meta);

/// Reads [meta] of an experiment, checked by the types that [lab.meta] of its lab declares, and [lab.use].
/// @param named_texts, overrides as of parse_experiment; "meta.KEY=VALUE" gives a key
/// @throws ConfigError naming file, line, key and requirement, also for mistakes of other sections
PrintMeta parse_meta(const std::vector<std::pair<std::string, std::string>>& named_texts,
                     const std::vector<std::string>& overrides);

/// Refuses a print without a key that its lab requires. @throws ConfigError naming all of them and where the
/// lab requires the first
void require_meta(const PrintMeta& meta);

}  // namespace firn
