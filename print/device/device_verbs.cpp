#include "print/device/device_verbs.h"

#include <fmt/core.h>

#include <charconv>
#include <cmath>

#include "files/usage_error.h"
#include "firn/enums.h"
#include "firn/heater_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/stage_command_t.hpp"

namespace firn {
namespace {

using Values = std::vector<double>;

DeviceOrder home(const Experiment&, const Values&, const OrderStamp& stamp) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kHome);
  return order_of(channels::kStageCommand, c, stamp);
}

DeviceOrder move(const Experiment&, const Values& v, const OrderStamp& stamp) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kMove);
  c.x_mm = v[0];
  c.y_mm = v[1];
  c.z_mm = v[2];
  c.speed_mm_s = v[3];
  return order_of(channels::kStageCommand, c, stamp);
}

DeviceOrder expose(const Experiment&, const Values& v, const OrderStamp& stamp) {
  lamp_command_t c{};
  c.verb = std::int8_t(LampVerb::kExpose);
  c.exposure_s = v[0];
  c.iris_percent = std::int32_t(std::lround(v[1]));
  return order_of(channels::kLampCommand, c, stamp);
}

DeviceOrder set_temperatures(const Experiment&, const Values& v, const OrderStamp& stamp) {
  heater_command_t c{};
  c.verb = std::int8_t(HeaterVerb::kSet);
  for (int n = 0; n < 3; ++n) c.set_degC[n] = v[std::size_t(n)];
  return order_of(channels::kHeaterCommand, c, stamp);
}

constexpr DeviceVerb kVerbs[] = {
    {"", "identify", "", 0, "who answers, and in which state it is"},
    {"", "status", "", 0, "the same, and what it measures"},
    {"", "stop", "", 0, "makes it safe"},
    {"stage", "home", "", 0, "homes the axes", &home},
    {"stage", "move", "X Y Z SPEED [mm, mm/s]", 4, "moves to a place within the limits", &move},
    {"lamp", "expose", "SECONDS IRIS [s, %]", 2, "opens the shutter for a time", &expose},
    {"heater", "set", "TIP LASER CONDUIT [degC]", 3, "set points; below -50 = off", &set_temperatures},
};

}  // namespace

std::span<const DeviceVerb> device_verbs() { return kVerbs; }

const DeviceVerb& device_verb(std::string_view node, std::string_view name) {
  std::string known;
  for (const DeviceVerb& v : kVerbs) {
    if (!v.node.empty() && v.node != node) continue;
    if (v.name == name) return v;
    known += (known.empty() ? "" : ", ") + std::string(v.name) +
             (v.values.empty() ? "" : " " + std::string(v.values));
  }
  throw UsageError(fmt::format("{} has no verb '{}'; known: {}", node, name, known));
}

Values verb_values(const DeviceVerb& verb, const std::vector<std::string>& texts) {
  if (texts.size() != verb.count)
    throw UsageError(fmt::format("{} takes {} values{}{}, not {}", verb.name, verb.count,
                                 verb.values.empty() ? "" : ": ", verb.values, texts.size()));
  Values values;
  for (const std::string& text : texts) {
    double v = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(v))
      throw UsageError(fmt::format("{}: '{}' is no number", verb.name, text));
    values.push_back(v);
  }
  return values;
}

}  // namespace firn
