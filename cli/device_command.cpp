#include "cli/device_command.h"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/option_set.h"
#include "config/devices.h"
#include "config/error.h"
#include "config/include.h"
#include "config/labs.h"
#include "drivers/link/driver_event.h"
#include "files/json_events.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "firn/enums.h"
#include "firn/heater_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/stage_command_t.hpp"
#include "firn/temperature_t.hpp"
#include "print/device/device_session.h"
#include "print/device/simulated_instruments.h"
#include "print/exit_codes.h"
#include "print/folder/node_makers.h"
#include "print/interrupt.h"

namespace firn {
namespace {

using Values = std::vector<double>;

constexpr double kIdentifyWithin_s = 10.0;
constexpr double kAnswered_s = 0.5;  // after its first bytes an instrument has named itself, if it can

struct Verb {
  std::string_view node;  ///< "" = every instrument
  std::string_view name;
  std::string_view values;  ///< "X Y Z [mm]"
  std::size_t count = 0;
  std::string_view meaning;
  void (*command)(DeviceSession&, const Values&) = nullptr;  ///< nullptr: no command
};

void home(DeviceSession& s, const Values&) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kHome);
  s.command(channels::kStageCommand, c);
}

void move(DeviceSession& s, const Values& v) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kMove);
  c.x_mm = v[0];
  c.y_mm = v[1];
  c.z_mm = v[2];
  c.speed_mm_s = v[3];
  s.command(channels::kStageCommand, c);
}

void expose(DeviceSession& s, const Values& v) {
  lamp_command_t c{};
  c.verb = std::int8_t(LampVerb::kExpose);
  c.exposure_s = v[0];
  c.iris_percent = std::int32_t(std::lround(v[1]));
  s.command(channels::kLampCommand, c);
}

void set_temperatures(DeviceSession& s, const Values& v) {
  heater_command_t c{};
  c.verb = std::int8_t(HeaterVerb::kSet);
  for (int n = 0; n < 3; ++n) c.set_degC[n] = v[std::size_t(n)];
  s.command(channels::kHeaterCommand, c);
}

constexpr Verb kVerbs[] = {
    {"", "identify", "", 0, "who answers, and in which state it is"},
    {"", "status", "", 0, "the same, and what it measures"},
    {"", "stop", "", 0, "makes it safe"},
    {"stage", "home", "", 0, "homes the axes", &home},
    {"stage", "move", "X Y Z SPEED [mm, mm/s]", 4, "moves to a place within the limits", &move},
    {"lamp", "expose", "SECONDS IRIS [s, %]", 2, "opens the shutter for a time", &expose},
    {"heater", "set", "TIP LASER CONDUIT [degC]", 3, "set points; below -50 = off", &set_temperatures},
};

std::string verbs_of(std::string_view node) {
  std::string text;
  for (const Verb& v : kVerbs)
    if (v.node.empty() || v.node == node)
      text += (text.empty() ? "" : ", ") + std::string(v.name) +
              (v.values.empty() ? "" : " " + std::string(v.values));
  return text;
}

const Verb& verb_of(std::string_view node, std::string_view name) {
  for (const Verb& v : kVerbs)
    if ((v.node.empty() || v.node == node) && v.name == name) return v;
  throw UsageError(fmt::format("{} has no verb '{}'; known: {}", node, name, verbs_of(node)));
}

Values values_of(const Verb& verb, const std::vector<std::string>& texts) {
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

const NamedMaker& maker_of(const Experiment& e, const std::string& node) {
  static std::vector<NamedMaker> makers;
  makers = taking_part(e);
  std::string known;
  for (const NamedMaker& m : makers) {
    const std::string name(info(m.id).name);
    if (!port_defaults(name)) continue;
    if (name == node) return m;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw UsageError(fmt::format("the lab has no instrument '{}'; it has {}", node, known));
}

// "12.345 > 4c 49 |LI|"
std::string line_of(const DeviceSession::Crossing& c) {
  std::string hex, text;
  for (const std::byte b : c.bytes) {
    hex += fmt::format("{:02x} ", unsigned(b));
    text += b >= std::byte{0x20} && b < std::byte{0x7f} ? char(b) : '.';
  }
  return fmt::format("{:10.3f} {} {}|{}|", c.ms, c.sent ? '>' : '<', hex, text);
}

std::string state_text(const device_state_t& s) {
  return fmt::format("{}, {}", drivers::name(DeviceState(s.state)),
                     s.identity.empty() ? "not identified" : s.identity);
}

// A lab's file names no part, which an ice lab's experiment must.
Experiment load_lab(const DeviceCommandOptions& o) {
  try {
    return load_experiment(o.lab, o.overrides);
  } catch (const ConfigError&) {
    std::vector<std::string> with_part = o.overrides;
    with_part.insert(with_part.begin(), "ice.mesh=\"-\"");
    try {
      return load_experiment(o.lab, with_part);
    } catch (const ConfigError&) {
    }
    throw;
  }
}

}  // namespace

int run_device(const DeviceCommandOptions& o) {
  Experiment e = load_lab(o);
  const NamedMaker& maker = maker_of(e, o.node);
  const Verb& verb = verb_of(o.node, o.verb);
  if (!verb.command) e.stage.home_at_start = OnOff::kOff;  // a question moves nothing
  const Values values = values_of(verb, o.values);
  const auto real = real_ports(e);
  std::optional<SimulatedInstruments> world;
  if (!real.contains(o.node)) world.emplace(e);
  const PortAddress address = world ? world->address(o.node) : real.at(o.node);
  if (!o.json)
    fmt::print("{} {}: {}\n", world ? "SIMULATED" : "REAL", o.node, world ? "sim:" : to_text(address));

  std::string record;
  std::optional<temperature_t> temperature;
  DeviceSession::Sinks sinks;
  sinks.crossing = [&](const DeviceSession::Crossing& c) {
    if (!o.trace && o.record.empty()) return;
    const std::string line = line_of(c);
    if (o.trace) fmt::print(stderr, "{}\n", line);
    record += line + "\n";
  };
  sinks.note = [&](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  sinks.message = [&](std::string_view channel, std::span<const std::byte> bytes) {
    if (temperature_t t;
        channel == channels::kTemperature.name && t.decode(bytes.data(), 0, int(bytes.size())) > 0)
      temperature = t;
  };
  DeviceSession session(maker.id, maker.make(dump(e), {}), address, sinks);
  const InterruptGuard guard;
  const auto interrupted = [] { return InterruptGuard::raised(); };

  int status = kOk;
  std::string text;
  const bool waits = verb.command || o.verb != "identify";
  const double ready_s = waits ? o.within_s : kIdentifyWithin_s;
  const auto ready = [&] { return session.safe() || (!waits && session.answered_for_s() > kAnswered_s); };
  if (!session.run_until(ready, ready_s, interrupted)) {
    status = InterruptGuard::raised() ? kInterrupted : kSafetyStop;
    text = fmt::format("{} within {:g} s",
                       session.answered_for_s() > 0.0 ? "it answers, and is not safe"
                       : session.state()              ? "no answer"
                                                      : "its port does not open",
                       ready_s);
  } else if (verb.command) {
    verb.command(session, values);
    if (!session.run_until([&] { return session.answer().has_value(); }, o.within_s, interrupted)) {
      status = InterruptGuard::raised() ? kInterrupted : kSafetyStop;
      text = "the command did not end within " + fmt::format("{:g} s", o.within_s);
    } else {
      const answer_t& a = *session.answer();
      text = std::string(drivers::name(Outcome(a.outcome))) + (a.text.empty() ? "" : ": " + a.text);
      if (Outcome(a.outcome) != Outcome::kDone) status = kFailed;
    }
  } else if (o.verb == "status" && o.node == "heater") {
    session.run_until([&] { return temperature.has_value(); }, kIdentifyWithin_s, interrupted);
  }
  if (o.verb == "stop" || status != kOk) {
    const bool safe = session.stop(o.verb == "stop" ? "firn device stop" : text);
    if (!safe && o.verb == "stop") {
      status = kSafetyStop;
      text = "it did not confirm that it is safe";
    }
  }
  if (!o.record.empty()) write_file_atomically(o.record, record);
  if (o.json) {
    nlohmann::ordered_json j = {{"node", o.node},   {"port", world ? "sim:" : to_text(address)},
                                {"real", !world},   {"verb", o.verb},
                                {"status", status}, {"text", text}};
    if (session.state()) {
      j["state"] = drivers::name(DeviceState(session.state()->state));
      j["identity"] = session.state()->identity;
    }
    if (temperature) {
      j["degC"] = temperature->degC;
      j["set_degC"] = temperature->set_degC;
    }
    std::puts(j.dump(2).c_str());
    return status;
  }
  if (session.state()) fmt::print("{}: {}\n", o.node, state_text(*session.state()));
  if (temperature)
    fmt::print("{:.2f}, {:.2f}, {:.2f} degC; set {:.2f}, {:.2f}, {:.2f}\n", temperature->degC[0],
               temperature->degC[1], temperature->degC[2], temperature->set_degC[0], temperature->set_degC[1],
               temperature->set_degC[2]);
  if (!text.empty()) fmt::print(status == kOk ? stdout : stderr, "{}: {}\n", o.node, text);
  return status;
}

void declare_device(OptionSet& options) {
  auto& o = options.calls(&run_device);
  options.option("LAB", o.lab, "lab or experiment file").required();
  options.option("NAME", o.node, "instrument: stage, jet, laser_profiler, lamp, robot, valve_a, ...")
      .required();
  options.option("VERB", o.verb, "identify, status, stop; stage: home, move; lamp: expose; heater: set")
      .required();
  options.option("VALUE", o.values, "values of the verb");
  options.option("--within", o.within_s, "longest wait for a command's end [s]").show_default();
  options.flag("--trace", o.trace, "bytes on stderr, with milliseconds");
  options.option("--record", o.record, "the same lines into a file");
  options.override_option(o.overrides);
  options.json_flag(o.json);
}

}  // namespace firn
