#include "runs/folder/run_meta.h"

#include <algorithm>
#include <stdexcept>

#include "files/json.h"

namespace firn::runs {
namespace {

MetaValue recorded_value(const std::string& key, const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number()) return value.get<double>();
  throw std::invalid_argument("provenance.json: meta." + key.substr(0, kMaxMetaKeyBytes) +
                              ": must be a text, a number, true or false");
}

}  // namespace

RunMeta run_meta(const ProvenanceDocument& provenance) {
  RunMeta meta;
  meta.host = provenance.text("host");
  const std::string text = provenance.text("meta");
  if (text.empty()) return meta;
  const nlohmann::json values = nlohmann::json::parse(text, nullptr, false);
  if (!values.is_object()) throw std::invalid_argument("provenance.json: meta: must be an object");
  for (const auto& [key, value] : values.items()) {
    if (!is_meta_key(key))
      throw std::invalid_argument("provenance.json: meta: '" + key.substr(0, kMaxMetaKeyBytes) +
                                  "' is no key");
    meta.values.push_back({key, recorded_value(key, value)});
  }
  return meta;
}

std::string meta_words(const Meta& meta) {
  std::string text;
  for (const MetaEntry& e : meta) text += (text.empty() ? "" : ", ") + e.key + " " + meta_value_text(e.value);
  return text;
}

std::string meta_text(const Meta& meta, std::string_view key) {
  const auto at = std::ranges::find(meta, key, &MetaEntry::key);
  return at == meta.end() ? "" : meta_value_text(at->value);
}

}  // namespace firn::runs
