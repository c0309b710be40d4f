// tie() holds the range of every numeric key to the check of the object that it configures: at both bounds,
// on both sides. The including test includes Catch.
#pragma once

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "config/error.h"
#include "config/experiment.h"
#include "config/fields.h"
#include "config/reader.h"

namespace firn::test {

/// Converts the struct S of a file's values to the configured object.
template <class S>
struct Probe {
  std::string keys;  ///< a key, or the start of several: "control.smf."
  std::function<void(S&)> build;
  std::string name = {};  ///< of the option in the message that refuses it; "" = the key's own
};

template <class S>
struct Kind {
  std::function<std::vector<Field>(S&)> fields;
  std::vector<Probe<S>> probes;
  std::vector<std::pair<std::string, std::string>> held_by_none;  ///< start of keys, and why
};

inline void set_number(Field& f, double v) {
  if (auto* d = std::get_if<double*>(&f.value)) **d = v;
  if (auto* i = std::get_if<std::int32_t*>(&f.value)) **i = std::int32_t(v);
  if (auto* i = std::get_if<std::int64_t*>(&f.value)) **i = std::int64_t(v);
  if (auto* i = std::get_if<std::uint64_t*>(&f.value)) **i = std::uint64_t(v);
  if (auto* list = std::get_if<std::vector<double>*>(&f.value)) **list = {v};
  if (auto* steps = std::get_if<std::vector<AlphaStep>*>(&f.value)) **steps = {{1, v}};
}

inline Field& field_of(std::vector<Field>& table, const std::string& key) {
  for (Field& f : table)
    if (f.key == key) return f;
  throw std::logic_error(key);
}

/// "" when accepted, else the reader's message.
template <class S>
std::string refused_by_config(const Kind<S>& kind, const std::string& key, const std::string& value) {
  S s;
  try {
    read_fields(kind.fields(s), key + " = " + value, "t.toml");
  } catch (const ConfigError& e) {
    CHECK(e.key == key);
    return e.what();
  }
  return "";
}

template <class S>
std::string refused_by_core(const Kind<S>& kind, const Probe<S>& probe, const std::string& key, double v) {
  S s;
  std::vector<Field> table = kind.fields(s);
  Field& f = field_of(table, key);
  set_number(f, v);
  const std::string name = probe.name.empty() ? std::string(f.name()) : probe.name;
  try {
    probe.build(s);
  } catch (const std::exception& e) {
    const std::string what = e.what();
    if (what.find(name) == std::string::npos) {
      INFO(what);
      CHECK(what.find("room for") != std::string::npos);  // the small part of this test has none for it
      return "";
    }
    return what;
  }
  return "";
}

struct Trial {
  double value;
  bool good;
};

/// The bounds and values just outside and, of an excluded bound, just inside.
inline std::vector<Trial> trials(const Field& f) {
  const bool whole = type_text(f) == "integer";
  const auto step = [&](double at) { return whole ? 1.0 : std::max(1e-6 * std::abs(at), 1e-9); };
  const Limits& l = f.limits;
  std::vector<Trial> t;
  if (l.min_excluded) {
    t.push_back({l.min, false});
    t.push_back({l.min + step(l.min), true});
  } else {
    t.push_back({l.min, true});
    t.push_back({l.min - step(l.min), false});
  }
  if (l.or_zero) {
    t.push_back({0.0, true});
    t.push_back({-step(0.0), false});
  }
  t.push_back({l.max, true});
  t.push_back({l.max + (l.max > 1e18 ? 1e17 : step(l.max)), false});
  return t;
}

inline std::string as_toml(const Field& f, double v) {
  if (type_text(f) == "integer") return std::to_string((long long)v);
  Experiment e;
  e.plant.sensor_noise_mm = v;
  std::vector<Field> table = fields(e);
  const std::string number = value_text(field_of(table, "plant.sensor_noise_mm"));
  return type_text(f) == "list of numbers" ? "[" + number + "]" : number;
}

template <class S>
void tie(const Kind<S>& kind) {
  S defaults;
  for (const Field& f : kind.fields(defaults)) {
    if (type_text(f) == "text") continue;
    const std::string key(f.key);
    INFO(key);
    CHECK((std::isfinite(f.limits.min) && std::isfinite(f.limits.max)));
    bool listed = false;
    for (const auto& [start, why] : kind.held_by_none) listed = listed || key.starts_with(start);
    int held = 0;
    for (const Trial& t : trials(f)) {
      const std::string value = as_toml(f, t.value), config = refused_by_config(kind, key, value);
      INFO(value << (config.empty() ? "" : ": ") << config);
      CHECK(config.empty() == t.good);
      for (const Probe<S>& p : kind.probes) {
        if (!key.starts_with(p.keys)) continue;
        ++held;
        const std::string core = refused_by_core(kind, p, key, t.value);
        INFO("core: " << core);
        CHECK(core.empty() == t.good);
      }
    }
    INFO("no probe builds what this key configures, and it is not listed as held by none, or both");
    CHECK((held == 0) == listed);
  }
}

}  // namespace firn::test
