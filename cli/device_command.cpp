// run_device speaks to one instrument of a lab alone: who it is, what it measures, and the orders of its
// kind.
#include "cli/commands.h"

#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "config/device_kinds.h"
#include "config/devices.h"
#include "config/labs.h"
#include "core/options/number.h"
#include "drivers/link/driver_event.h"
#include "files/cassette.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "firn/enums.h"
#include "print/bringup/raw_line.h"
#include "print/device/device_run.h"
#include "print/device/lab_experiment.h"
#include "print/device/profile_files.h"
#include "print/device/simulated_instruments.h"
#include "print/folder/taking_part.h"
#include "print/hosts/at_host.h"
#include "print/inputs/driver_input.h"
#include "print/interrupt.h"

namespace firn {
namespace {

struct DeviceCommandOptions {
  std::string lab;   ///< lab or experiment file
  std::string node;  ///< "stage", "lamp", ...
  std::string verb;
  std::vector<std::string> values;  ///< of the verb
  double within_s = 120.0;          ///< longest wait for the end of an order
  bool trace = false;               ///< each piece of bytes on stderr
  std::string record;               ///< file for the same as lines; empty: none
  std::string out;                  ///< .csv or .png of profiles, .png of pictures
  bool watch = false;               ///< status: until Ctrl-C
  bool dry_run = false;             ///< the bytes of the order, and no port opened
  bool unsafe = false;              ///< raw: bytes past driver, limits and stop
  bool far = false;                 ///< a jog beyond 5 mm and 10 mm/s
  bool json = false;
  std::vector<std::string> overrides;
};

constexpr double kRawQuiet_s = 1.0;

void check_node(const Product& product, const Experiment& e, const std::string& node) {
  std::string known;
  for (const NamedMaker& m : taking_part(product, e)) {
    const std::string name(info(m.id).name);
    if (!port_defaults(name)) continue;
    if (name == node) return;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw UsageError(fmt::format("the lab has no instrument '{}'; it has {}", node, known));
}

std::string state_text(const device_state_t& s) {
  return fmt::format("{}, {}", drivers::name(DeviceState(s.state)),
                     s.identity.empty() ? "not identified" : s.identity);
}

// \r, \n, \xNN and \\ stand for bytes that a shell does not pass.
std::string unescaped(const std::string& text) {
  std::string bytes;
  for (std::size_t n = 0; n < text.size(); ++n) {
    if (text[n] != '\\') {
      bytes += text[n];
      continue;
    }
    const char c = ++n < text.size() ? text[n] : '\0';
    const std::optional<std::uint8_t> byte =
        c == 'x' ? hex_byte(std::string_view(text).substr(n + 1, 2)) : std::nullopt;
    if (c == 'r')
      bytes += '\r';
    else if (c == 'n')
      bytes += '\n';
    else if (c == '\\')
      bytes += '\\';
    else if (byte)
      bytes += char(*byte);
    else
      throw UsageError("raw '" + text + "': after \\ comes r, n, \\ or xNN");
    if (byte) n += 2;
  }
  return bytes;
}

std::string escaped(std::string_view bytes) {
  std::string text;
  for (const char c : bytes)
    text += c == '\r'               ? "\\r"
            : c == '\n'             ? "\\n"
            : c == '\\'             ? "\\\\"
            : c >= 0x20 && c < 0x7f ? std::string(1, c)
                                    : fmt::format("\\x{:02X}", unsigned(std::uint8_t(c)));
  return text;
}

int tell_verbs(const DeviceCommandOptions& o) {
  auto j = nlohmann::ordered_json::array();
  for (const DeviceVerb* v : verbs_of(o.node)) {
    j.push_back({{"verb", v->name}, {"values", v->values}, {"meaning", v->meaning}});
    if (!o.json) fmt::print("{:<44}{}\n", fmt::format("{} {}", v->name, v->values), v->meaning);
  }
  if (o.json) std::puts(j.dump(2).c_str());
  return kOk;
}

int run_raw(const DeviceCommandOptions& o, const PortAddress& address) {
  if (o.values.size() != 1) throw UsageError("raw takes one text: 'GUSFA\\r'");
  const std::string bytes = unescaped(o.values[0]);
  if (!o.unsafe) throw UsageError("raw passes the driver, its limits and its stop: only with --unsafe");
  std::string heard;
  bool open = true;
  if (!o.dry_run) {
    RawLine line(address);
    open = line.is_open();
    if (open)
      heard = line.ask(
          bytes, [](std::string_view) { return false; }, kRawQuiet_s);
    else
      heard = line.trouble();
  }
  if (o.json)
    std::puts(nlohmann::ordered_json{
        {"node", o.node}, {"sent", escaped(bytes)}, {"open", open}, {"received", escaped(heard)}}
                  .dump(2)
                  .c_str());
  else
    fmt::print("> {}\n{} {}\n", escaped(bytes), open ? "<" : "no port:", escaped(heard));
  return !open || (heard.empty() && !o.dry_run) ? kSafetyStop : kOk;
}

void show_json(const DeviceCommandOptions& o, const DeviceReport& r, const std::string& port, bool real,
               const std::vector<std::string>& sent) {
  nlohmann::ordered_json j = {{"node", o.node}, {"port", port},       {"real", real},
                              {"verb", o.verb}, {"status", r.status}, {"text", r.text}};
  if (r.state) {
    j["state"] = drivers::name(DeviceState(r.state->state));
    j["identity"] = r.state->identity;
  }
  if (r.temperature) {
    j["degC"] = r.temperature->degC;
    j["set_degC"] = r.temperature->set_degC;
  }
  if (r.gas) {
    j["sccm"] = r.gas->sccm;
    j["set_sccm"] = r.gas->set_sccm;
    j["pressure_kPa"] = r.gas->pressure_kPa;
  }
  if (!r.readings_mm.empty()) j["readings_mm"] = r.readings_mm;
  for (const height_profile_t& p : r.profiles)
    j["profiles"].push_back(
        {{"row", p.row}, {"x0_mm", p.x0_mm}, {"dx_mm", p.dx_mm}, {"y_mm", p.y_mm}, {"z_mm", p.z_mm}});
  for (const camera_frame_t& f : r.frames)
    j["pictures"].push_back({{"index", f.index},
                             {"delay_us", f.delay_us},
                             {"width", f.width},
                             {"height", f.height},
                             {"white", f.white}});
  if (o.dry_run) j["sent"] = sent;
  std::puts(j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

void show_exchange(const DeviceCommandOptions& o, const DeviceReport& r,
                   const std::vector<std::string>& sent) {
  for (const std::string& line : sent) fmt::print("{}", line);
  if (r.state && !o.dry_run) fmt::print("{}: {}\n", o.node, state_text(*r.state));
  if (r.temperature)
    fmt::print("{:.2f}, {:.2f}, {:.2f} degC; set {:.2f}, {:.2f}, {:.2f}\n", r.temperature->degC[0],
               r.temperature->degC[1], r.temperature->degC[2], r.temperature->set_degC[0],
               r.temperature->set_degC[1], r.temperature->set_degC[2]);
  if (r.gas)
    fmt::print("atomizer {:.2f}, sheath {:.2f} sccm; set {:.2f}, {:.2f}; {:.1f}, {:.1f} kPa\n",
               r.gas->sccm[0], r.gas->sccm[1], r.gas->set_sccm[0], r.gas->set_sccm[1], r.gas->pressure_kPa[0],
               r.gas->pressure_kPa[1]);
  if (!r.text.empty()) fmt::print(r.status == kOk ? stdout : stderr, "{}: {}\n", o.node, r.text);
}

int at_host(const Experiment& lab, const std::string& host, const DeviceCommandOptions& o) {
  if (!o.record.empty() || !o.out.empty())
    throw UsageError(fmt::format("{} is at host {}: --record and -o write files there; run firn device on it",
                                 o.node, host));
  std::vector<std::string> words{o.node, o.verb};
  words.insert(words.end(), o.values.begin(), o.values.end());
  for (const auto& [given, name] : {std::pair(o.trace, "--trace"),
                                    {o.watch, "--watch"},
                                    {o.unsafe, "--unsafe"},
                                    {o.far, "--far"},
                                    {o.json, "--json"}})
    if (given) words.emplace_back(name);
  words.push_back(fmt::format("--within={}", o.within_s));
  return run_at_host(lab, host, "device", words);
}

/// @returns kOk; kFailed when the instrument refused or failed; kSafetyStop when the link gave no answer;
/// kInterrupted after Ctrl-C, with the instrument made safe. @throws UsageError: no such instrument or verb,
/// a value that is none
int run_device(const Product& product, const DeviceCommandOptions& o) {
  DeviceJob job{product};
  job.e = load_lab_experiment(o.lab, o.overrides);
  check_node(product, job.e, o.node);
  if (o.verb == "?") return tell_verbs(o);
  if (const std::string host = host_of(job.e, o.node); !host.empty() && !o.dry_run)
    return at_host(job.e, host, o);
  const auto outside =
      with_driver_files(outside_ports(job.e), job.e, std::filesystem::path(o.lab).parent_path());
  if (o.dry_run && is_python_driver(job.e, o.node))
    throw UsageError("--dry-run: the class that drives " + o.node +
                     " has no simulated instrument to answer it");
  std::optional<SimulatedInstruments> world;
  const bool simulated = !outside.contains(o.node);
  const auto address = [&] {
    if (simulated || o.dry_run) world.emplace(job.e);
    return world ? world->address(o.node) : outside.at(o.node);
  };
  if (o.verb == "raw") return run_raw(o, o.dry_run ? PortAddress{} : address());
  job.node = o.node;
  job.verb = &device_verb(o.node, o.verb);
  job.values = verb_values(*job.verb, o.values);
  job.far = o.far;
  job.within_s = o.within_s;
  if (o.watch && (o.verb != "status" || o.dry_run)) throw UsageError("--watch: only with status");
  const PortAddress at = address();
  const bool real = !world && at.real();
  const std::string port = world ? "sim:" : to_text(at);
  if (!o.json)
    fmt::print("{} {}: {}\n",
               o.dry_run ? "DRY RUN"
               : real    ? "REAL"
                         : "SIMULATED",
               o.node, o.dry_run ? "what the order sends, from a simulation; no port was opened" : port);

  std::string record = cassette_head(o.node, (real ? "REAL " : "SIMULATED ") + port, dump(job.e));
  std::vector<std::string> sent;
  DeviceSinks sinks;
  sinks.tape = [&](const std::string& line, bool ordered) {
    if (o.trace) fmt::print(stderr, "{}", line);
    if (!o.record.empty()) record += line;
    if (o.dry_run && (ordered || !job.verb->order) && line.find(" > ") != line.npos) sent.push_back(line);
  };
  sinks.note = [&](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  if (o.watch)
    sinks.state = [&](const device_state_t& s) {
      fmt::print("{}: {}\n", o.node, state_text(s));
      std::fflush(stdout);
    };
  sinks.watch = o.watch;
  const InterruptGuard guard;
  sinks.interrupted = [] { return InterruptGuard::raised(); };
  const DeviceReport report = run_verb(job, at, sinks);
  if (!o.record.empty()) write_file_atomically(o.record, record);
  if (!o.out.empty() && !report.frames.empty()) write_frames(o.out, report.frames);
  if (!o.out.empty() && report.frames.empty()) write_profiles(o.out, report.profiles);
  if (o.json)
    show_json(o, report, port, real, sent);
  else
    show_exchange(o, report, sent);
  return report.status;
}

}  // namespace

void declare_device(OptionSet& options) {
  auto& o = options.calls(&run_device);
  options.option("LAB", o.lab, "lab or experiment file").required();
  options.option("NAME", o.node, "instrument: stage, jet, laser_profiler, lamp, robot, valve_a, ...")
      .required();
  options
      .option("VERB", o.verb, "identify, status, stop, serial, reset, raw, or one of its kind; ? names them")
      .required();
  options.option("VALUE", o.values, "values of the verb");
  options.option("--within", o.within_s, "longest wait for an order's end [s]").show_default();
  options.flag("--trace", o.trace, "bytes on stderr, with milliseconds");
  options.option("--record", o.record, "the same lines into a file, a cassette; firn cassette");
  options.flag("--dry-run", o.dry_run, "the bytes that the order sends; no port is opened");
  options.flag("--watch", o.watch, "status: each change, until Ctrl-C");
  options.option("--out", o.out, "profiles as .csv or .png, pictures as .png");
  options.flag("--far", o.far, "a jog beyond 5 mm and 10 mm/s");
  options.flag("--unsafe", o.unsafe, "raw: bytes past driver, limits and stop");
  options.override_option(o.overrides);
  options.json_flag(o.json);
}

}  // namespace firn
