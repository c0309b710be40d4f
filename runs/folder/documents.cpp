#include "runs/folder/documents.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/grid/outline.h"
#include "files/json.h"

namespace firn::runs {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxShown = 100;
constexpr const char* kSizeCut = "size_cut";  // as in metrics.csv

[[noreturn]] void bad(const std::string& where, const std::string& what) {
  throw std::invalid_argument(where + ": " + what);
}

Json object_of(std::string_view text, const std::string& name) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception& e) {
    const auto* mistake = dynamic_cast<const Json::parse_error*>(&e);
    bad(name, "byte " + std::to_string(mistake ? mistake->byte : 0) + ": is no JSON");
  }
  if (!json.is_object()) bad(name, "must be a JSON object");
  return json;
}

const Json& at(const Json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) bad(where, std::string("has no key ") + key);
  return *found;
}

std::string text_of(const Json& value, const std::string& where) {
  if (!value.is_string()) bad(where, "must be a text");
  return value.get<std::string>();
}

std::int64_t whole(const Json& value, const std::string& where, std::int64_t low, std::int64_t high) {
  const bool fits = value.is_number_unsigned() ? value.get<std::uint64_t>() <=
                                                     std::uint64_t(std::numeric_limits<std::int64_t>::max())
                                               : value.is_number_integer();
  if (!fits || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high)
    bad(where, "must be a whole number in [" + std::to_string(low) + ", " + std::to_string(high) + "]");
  return value.get<std::int64_t>();
}

double finite(const Json& value, const std::string& where, const char* unit) {
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    bad(where, std::string("must be a number [") + unit + "]");
  return value.get<double>();
}

PrintedPart part_of(const Json& part, const std::string& where) {
  if (!part.is_object()) bad(where, "must be an object");
  PrintedPart p{text_of(at(part, "name", where), where + ".name"), {}};
  const Json& size = at(part, "size_mm", where);
  if (!size.is_array() || size.size() != p.size_mm.size()) bad(where, "size_mm must be a list of 3 numbers");
  for (std::size_t n = 0; n < p.size_mm.size(); ++n) p.size_mm[n] = finite(size[n], where + ".size_mm", "mm");
  return p;
}

std::pair<std::string, std::string> input_of(const Json& input, const std::string& where) {
  if (!input.is_object()) bad(where, "must be an object");
  const std::string role = text_of(at(input, "role", where), where + ".role"),
                    sha = text_of(at(input, "sha256", where), where + ".sha256");
  if (sha.size() != 64 || sha.find_first_not_of("0123456789abcdef") != sha.npos)
    bad(where, "input '" + role.substr(0, kMaxShown) + "': '" + sha.substr(0, kMaxShown) +
                   "' is no SHA-256, 64 hexadecimal digits");
  return {role, sha};
}

Fingerprint results_of(const Json& value, const std::string& where) {
  if (!value.is_object()) bad(where, "must be an object");
  std::map<std::string, std::string> texts;
  for (const auto& [function, digest] : value.items())
    texts[function.substr(0, kMaxShown)] = text_of(digest, where + "." + function.substr(0, kMaxShown));
  try {
    return fingerprint_of(texts);
  } catch (const std::invalid_argument& e) {
    bad(where, e.what());
  }
}

// A text or a number; of objects the members, as "{"plant":1}". Nested no deeper: writing out recurses.
std::string shown(const Json& value, const std::string& where) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_structured())
    for (const Json& member : value)
      if (member.is_structured()) bad(where, "is nested too deep");
  return value.is_null() ? "" : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

PrintUse use_of(const Json& json, const std::string& where) {
  if (!json.is_object()) bad(where, "must be an object");
  const auto number = [&](const Json& of, const char* key, const char* unit) {
    const double value = finite(at(of, key, where), where + "." + key, unit);
    if (value < 0.0) bad(where + "." + key, "must not be negative");
    return value;
  };
  PrintUse use;
  use.amount = whole(at(json, "amount", where), where + ".amount", 0, std::int64_t(1) << 53);
  use.volume_mm3 = number(json, "volume_mm3", "mm^3");
  use.depositing = text_of(at(json, "depositing", where), where + ".depositing");
  const Json& all = at(json, "instruments", where);
  if (!all.is_object()) bad(where + ".instruments", "must be an object");
  for (const auto& [node, one] : all.items()) {
    if (!one.is_object()) bad(where + ".instruments." + node, "must be an object");
    use.instruments.emplace(
        node, InstrumentUse{text_of(at(one, "port", where), where + ".port"), number(one, "hours", "h"),
                            number(one, "volume_mm3", "mm^3")});
  }
  return use;
}

}  // namespace

std::string ProvenanceDocument::text(std::string_view key) const {
  const auto found = std::ranges::find(texts, key, &std::pair<std::string, std::string>::first);
  return found == texts.end() ? "" : found->second;
}

ProvenanceDocument parse_provenance(std::string_view text, const std::string& name) {
  const Json json = object_of(text, name);
  ProvenanceDocument p;
  for (const auto& [key, value] : json.items()) {
    const std::string where = name + ": " + key.substr(0, kMaxShown);
    if (key == "inputs") {
      if (!value.is_array()) bad(where, "must be a list");
      p.has_inputs = true;
      for (std::size_t n = 0; n < value.size(); ++n)
        p.inputs.push_back(input_of(value[n], where + "[" + std::to_string(n) + "]"));
    } else if (key == "command_line") {
      if (!value.is_array()) bad(where, "must be a list");
      for (const Json& word : value) p.command_line.push_back(text_of(word, where));
    } else if (key == "results") {
      p.results = results_of(value, where);
    } else {
      if (key == "run_id") p.run_id = whole(value, where, 0, std::numeric_limits<std::int64_t>::max());
      if (key == "scheme") text_of(value, where);
      p.texts.emplace_back(key, shown(value, where));
    }
  }
  return p;
}

bool can_go_on(const RunResult& r) { return r.outcome != "finished" && r.outcome != "out of tolerance"; }

std::optional<bool> within_tolerance(const RunResult& r) {
  if (can_go_on(r)) return std::nullopt;
  if (r.outcome == "out of tolerance") return false;
  if (!r.error || !r.tolerance_um) return std::nullopt;
  return r.error->rms_um <= *r.tolerance_um;
}

std::string result_text(const RunResult& r) {
  nlohmann::ordered_json j = {{"outcome", r.outcome}, {"status", r.status}, {"layers", r.layers},
                              {"reason", r.reason},   {"error", nullptr},   {"tolerance_um", nullptr}};
  if (r.error)
    j["error"] = {{"mean_um", r.error->mean_um},
                  {"rms_um", r.error->rms_um},
                  {"std_um", r.error->std_um},
                  {"rms_inside_um", r.error->rms_inside_um},
                  {"rms_rim_um", r.error->rms_rim_um}};
  if (r.tolerance_um) j["tolerance_um"] = *r.tolerance_um;
  if (r.part) j["part"] = {{"name", r.part->name}, {"size_mm", r.part->size_mm}};
  if (r.overspill_percent) j["overspill_percent"] = *r.overspill_percent;
  if (r.outline) {
    auto& values = j["outline"] = nlohmann::ordered_json::object();
    for (const OutlineMetric& m : kOutlineMetrics)
      if (const double v = (*r.outline).*m.value * m.factor; std::isfinite(v))
        values[std::string(m.name)] = v;
    if (r.outline->cut) values[kSizeCut] = true;
  }
  if (r.use) {
    auto& use = j["use"] = {{"amount", r.use->amount},
                            {"volume_mm3", r.use->volume_mm3},
                            {"depositing", r.use->depositing},
                            {"instruments", nlohmann::ordered_json::object()}};
    for (const auto& [node, i] : r.use->instruments)
      use["instruments"][node] = {{"port", i.port}, {"hours", i.hours}, {"volume_mm3", i.volume_mm3}};
  }
  if (!r.audit.empty()) j["audit"] = r.audit;
  return j.dump(2, ' ', false, Json::error_handler_t::replace);
}

RunResult parse_result(std::string_view text, const std::string& name) {
  const Json json = object_of(text, name);
  const auto where = [&](const char* key) { return name + ": " + key; };
  const auto number = [&](const char* key) {
    return int(whole(at(json, key, name), where(key), std::numeric_limits<int>::min(),
                     std::numeric_limits<int>::max()));
  };
  RunResult r{text_of(at(json, "outcome", name), where("outcome")), number("status"), number("layers"),
              text_of(at(json, "reason", name), where("reason"))};
  const auto known = [&](const char* key) -> const Json* {  // an older program did not write it
    const auto found = json.find(key);
    return found == json.end() || found->is_null() ? nullptr : &*found;
  };
  if (const Json* error = known("error")) {
    if (!error->is_object()) bad(where("error"), "must be an object");
    const auto um = [&](const char* key) {
      return finite(at(*error, key, where("error")), where(key), "um");
    };
    r.error = MapError{um("mean_um"), um("rms_um"), um("std_um"), um("rms_inside_um"), um("rms_rim_um")};
  }
  if (const Json* tolerance = known("tolerance_um"))
    r.tolerance_um = finite(*tolerance, where("tolerance_um"), "um");
  if (const Json* part = known("part")) r.part = part_of(*part, where("part"));
  if (const Json* share = known("overspill_percent"))
    r.overspill_percent = finite(*share, where("overspill_percent"), "%");
  if (const Json* outline = known("outline")) {
    if (!outline->is_object()) bad(where("outline"), "must be an object");
    r.outline.emplace();
    for (const OutlineMetric& m : kOutlineMetrics)
      if (const auto value = outline->find(std::string(m.name)); value != outline->end())
        (*r.outline).*m.value =
            finite(*value, where("outline") + "." + std::string(m.name), std::string(m.unit).c_str()) /
            m.factor;
    if (const auto cut = outline->find(kSizeCut); cut != outline->end()) {
      if (!cut->is_boolean()) bad(where("outline") + "." + kSizeCut, "must be true or false");
      r.outline->cut = cut->get<bool>();
    }
  }
  if (const Json* use = known("use")) r.use = use_of(*use, where("use"));
  if (const Json* audit = known("audit")) r.audit = text_of(*audit, where("audit"));
  return r;
}

}  // namespace firn::runs
