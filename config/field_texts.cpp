#include "config/field_texts.h"

#include <algorithm>

#include "config/error.h"
#include "config/field_rules.h"

namespace firn {

std::string fields_toml(const std::vector<Field>& fields) {
  std::string out;
  std::string_view section;
  for (const Field& f : fields) {
    if (f.section() != section) {
      section = f.section();
      out += (out.empty() ? "[" : "\n[") + std::string(section) + "]\n";
    }
    out += std::string(f.name()) + " = " + value_text(f) + "\n";
  }
  return out;
}

std::string fields_markdown(const std::vector<Field>& fields) {
  std::string out;
  std::string_view section;
  for (const Field& f : fields) {
    if (f.section() != section) {
      section = f.section();
      out += "\n## [" + std::string(section) +
             "]\n\n| key | default | unit | allowed | meaning |\n|---|---|---|---|---|\n";
    }
    out += "| `" + std::string(f.name()) + "` | `" + value_text(f) + "` | " + std::string(f.unit) + " | " +
           limits_text(f) + " | " + std::string(f.meaning) + " |\n";
  }
  return out;
}

void FieldRules::require(bool ok, const std::string& key, const std::string& problem) const {
  if (ok) return;
  const auto field = std::find_if(table_.begin(), table_.end(), [&](const Field& f) { return f.key == key; });
  const auto origin = origins_.find(key);
  throw ConfigError(file_, origin == origins_.end() ? 0 : origin->second.line, key,
                    key + " = " + value_text(*field) + ": " + problem);
}

}  // namespace firn
