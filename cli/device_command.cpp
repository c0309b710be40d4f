#include "cli/device_command.h"

#include <fmt/core.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/option_set.h"
#include "config/devices.h"
#include "config/labs.h"
#include "drivers/link/driver_event.h"
#include "files/json_events.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "firn/temperature_t.hpp"
#include "print/device/device_session.h"
#include "print/device/device_verbs.h"
#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "print/exit_codes.h"
#include "print/folder/node_makers.h"
#include "print/interrupt.h"

namespace firn {
namespace {

constexpr double kIdentifyWithin_s = 10.0;
constexpr double kAnswered_s = 0.5;  // after its first bytes an instrument has named itself, if it can

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

std::string state_text(const device_state_t& s) {
  return fmt::format("{}, {}", drivers::name(DeviceState(s.state)),
                     s.identity.empty() ? "not identified" : s.identity);
}

}  // namespace

int run_device(const DeviceCommandOptions& o) {
  Experiment e = load_lab_experiment(o.lab, o.overrides);
  const NamedMaker& maker = maker_of(e, o.node);
  const DeviceVerb& verb = device_verb(o.node, o.verb);
  if (!verb.order) e.stage.home_at_start = OnOff::kOff;  // a question moves nothing
  const std::vector<double> values = verb_values(verb, o.values);
  const auto outside = outside_ports(e);
  std::optional<SimulatedInstruments> world;
  if (!outside.contains(o.node)) world.emplace(e);
  const PortAddress address = world ? world->address(o.node) : outside.at(o.node);
  const bool real = !world && address.real();
  const std::string port = world ? "sim:" : to_text(address);
  if (!o.json) fmt::print("{} {}: {}\n", real ? "REAL" : "SIMULATED", o.node, port);

  std::string record = cassette_head(o.node, (real ? "REAL " : "SIMULATED ") + port, dump(e));
  std::optional<temperature_t> temperature;
  DeviceSession::Sinks sinks;
  if (o.trace || !o.record.empty())
    sinks.tape = [&](const std::string& line) {
      if (o.trace) fmt::print(stderr, "{}", line);
      record += line;
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
  const bool waits = verb.order || o.verb != "identify";
  const double ready_s = waits ? o.within_s : kIdentifyWithin_s;
  const auto ready = [&] { return session.safe() || (!waits && session.answered_for_s() > kAnswered_s); };
  if (!session.run_until(ready, ready_s, interrupted)) {
    status = InterruptGuard::raised() ? kInterrupted : kSafetyStop;
    text = fmt::format("{} within {:g} s",
                       session.answered_for_s() > 0.0 ? "it answers, and is not safe"
                       : session.state()              ? "no answer"
                                                      : "its port does not open",
                       ready_s);
  } else if (verb.order) {
    std::string words = o.verb;
    for (const std::string& value : o.values) words += " " + value;
    session.command([&](const OrderStamp& stamp) { return verb.order(e, values, stamp); }, words);
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
    nlohmann::ordered_json j = {{"node", o.node}, {"port", port},     {"real", real},
                                {"verb", o.verb}, {"status", status}, {"text", text}};
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
  options.option("--record", o.record, "the same lines into a file, a cassette; firn cassette");
  options.override_option(o.overrides);
  options.json_flag(o.json);
}

}  // namespace firn
