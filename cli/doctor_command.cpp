// run_doctor reports the requirements of live prints that this machine does not meet, each with its remedy.
#include "cli/commands.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "config/assumptions.h"
#include "config/devices.h"
#include "core/options/for_people.h"
#include "files/command.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "lcmtypes/channels.h"
#include "print/bringup/raw_line.h"
#include "print/device/lab_experiment.h"
#include "print/hosts/at_host.h"
#include "print/live/bus_check.h"
#include "print/live/busy_machine.h"
#include "print/process/bus_port.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

struct DoctorOptions {
  std::string lab;                     ///< lab file; empty: the machine alone
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
  bool json = false;
};

namespace fs = std::filesystem;

struct Check {
  std::string name;
  bool ok = false;
  std::string found;  ///< the state, or the defect
  std::string mend;   ///< empty when nothing is wrong
};

Check multicast() {
  const std::string trouble = check_multicast();
  if (trouble.empty()) return {"multicast", true, "a datagram sent with ttl 0 came back", ""};
  const auto mend = trouble.find("; mend: ");  // told once for those who read the sentence alone
  return {"multicast", false, trouble.substr(0, mend),
          trouble.substr(mend + 8) + " (or print with --bus in-process)"};
}

Check receive_buffer() {
  const int granted = granted_receive_buffer();
  const std::string found =
      std::to_string(granted) + " bytes granted, " + std::to_string(kWantedReceiveBuffer) + " wanted";
  if (granted >= kWantedReceiveBuffer) return {"receive buffer", true, found, ""};
  return {"receive buffer", false, found + ": messages get lost and are sent again",
          "sysctl -w net.core.rmem_max=" + std::to_string(kWantedReceiveBuffer)};
}

Check ports() {
  int free = 0;
  for (int n = 0; n < kBusPorts; n += 100) free += bus_port_is_free(kFirstBusPort + n);
  const std::string found =
      std::to_string(free) + " of " + std::to_string(kBusPorts / 100) + " ports tried are free";
  return {"ports", free > 0, found,
          free > 0 ? "" : "end the programs that hold UDP ports from " + std::to_string(kFirstBusPort)};
}

Check disk() {
  constexpr std::uintmax_t kWanted = std::uintmax_t(1) << 30;
  std::error_code error;
  const auto space = fs::space(".", error);
  if (error) return {"disk", false, error.message(), "run from a folder that can be written"};
  const std::string found = std::to_string(space.available >> 20) + " MiB free here";
  return {"disk", space.available >= kWanted, found,
          space.available >= kWanted ? "" : "a print needs up to 1 GiB: make room"};
}

Check programs() {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  std::string missing;
  const auto need = [&](std::string_view name) {
    if (!fs::exists(folder / name)) missing += (missing.empty() ? "" : ", ") + std::string(name);
  };
  need("world");
  need("recorder");
  need("relay");
  for (const NodeInfo& n : nodes())
    if (int(n.id) < kReplayedNodeCount) need(n.name);
  if (missing.empty()) return {"programs", true, "every process of a print lies beside this program", ""};
  return {"programs", false, "missing beside this program: " + missing,
          "run ./firn doctor: it builds what is missing"};
}

// A real port: may this user open it, has it a lasting name, does somebody answer the call.
Check instrument(const std::string& node, const PortAddress& address) {
  Check c{node, false, to_text(address), ""};
  if (address.kind == PortAddress::Kind::kPython) {
    c.ok = true;
    c.found += " is opened by its class in Python: firn device LAB " + node + " identify asks it";
    return c;
  }
  if (address.kind == PortAddress::Kind::kSerial) {
    std::error_code error;
    if (!fs::exists(address.place, error)) {
      c.found += ": no such device";
      c.mend = "plug it in; ls -l /dev/serial/by-id names what is there";
      return c;
    }
    if (::access(address.place.c_str(), R_OK | W_OK) != 0) {
      c.found += ": this user may not open it";
      c.mend = "sudo usermod -aG dialout $USER, then log in again";
      return c;
    }
  }
  const RawLine line(address);
  if (!line.is_open()) {
    c.found = line.trouble().empty() ? c.found + ": does not open" : line.trouble();  // names the address
    c.mend =
        address.kind == PortAddress::Kind::kTcp ? "power, cable, address; ping it" : "close what holds it";
    return c;
  }
  c.ok = true;
  c.found += " opens";
  if (address.place.starts_with("/dev/tty"))
    c.found += "; its name may change with the next plug: write its path in /dev/serial/by-id";
  return c;
}

// A heartbeat later than the lease stops a print.
Check wake_ups() {
  constexpr double kFor_s = 3.0, kLease_s = 0.3, kMsPerS = 1e3;
  const double longest_s = longest_delay_s(kFor_s);
  const std::string found = "the latest of " + for_people(kFor_s) + " s came " +
                            for_people(longest_s * kMsPerS) + " ms late; " + for_people(kLease_s * kMsPerS) +
                            " ms stop a print";
  // A late wake-up is no failure: it belongs to this moment, and nothing is wrong with the computer.
  return {"wake-ups", true, found + (longest_s < kLease_s ? "" : std::string(": ") + kPriorityRemedy), ""};
}

// Another computer of the lab: whether ssh reaches it, and its own doctor's findings.
std::vector<Check> checks_of_host(const Experiment& lab, const std::string& host) {
  const auto began = std::chrono::steady_clock::now();
  const CommandEnd end = run_command(words_at_host(lab, host, "doctor", {"--json"}));
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  nlohmann::ordered_json told;
  try {
    told = nlohmann::ordered_json::parse(end.output);
  } catch (const nlohmann::json::exception&) {
    return {{"host " + host, false, end.reason(),
             "ssh must reach it without a password, and find firn there; docs/hosts.md"}};
  }
  std::vector<Check> checks;
  const bool same = told.value("sources", "") == build_sources();
  checks.push_back(
      {"host " + host, same,
       "answers, with its own checks in " + for_people(took_s) + " s; " + told.value("platform", ""),
       same ? "" : "it has another build of firn: firn host --install LAB copies this one there"});
  for (const auto& c : told.value("checks", nlohmann::ordered_json::array()))
    checks.push_back({host + ": " + c.value("check", ""), c.value("ok", false), c.value("found", ""),
                      c.value("mend", "")});
  return checks;
}

/// @returns kOk when nothing is wrong, else kFailed
int run_doctor(const DoctorOptions& options) {
  std::vector<Check> checks{multicast(), receive_buffer(), ports(), disk(), programs(), wake_ups()};
  if (!options.lab.empty()) {
    const Experiment e = load_lab_experiment(options.lab, options.overrides);
    for (const auto& [host, address] : e.hosts.address)
      for (const Check& c : checks_of_host(e, host)) checks.push_back(c);
    for (const auto& [node, address] : real_ports(e)) {
      if (!host_of(e, node).empty()) continue;  // its host looks at it
      checks.push_back(instrument(node, address));
      if (const std::string text = assumptions_text(e, node); !text.empty())
        checks.push_back({node, true, text, ""});
    }
  }
  bool well = true;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Check& c : checks) {
    well = well && c.ok;
    if (options.json)
      list.push_back({{"check", c.name}, {"ok", c.ok}, {"found", c.found}, {"mend", c.mend}});
    else
      std::printf("%-15s %s  %s%s\n", c.name.c_str(), c.ok ? "ok  " : "WRONG", c.found.c_str(),
                  c.mend.empty() ? "" : ("\n                mend: " + c.mend).c_str());
  }
  if (options.json)
    std::puts(nlohmann::ordered_json{
        {"well", well}, {"platform", platform_description()}, {"sources", build_sources()}, {"checks", list}}
                  .dump(2)
                  .c_str());
  return well ? kOk : kFailed;
}

}  // namespace

void declare_doctor(OptionSet& options) {
  auto& o = options.calls(run_doctor);
  options.option("LAB", o.lab, "lab file: its real ports are looked at too");
  options.override_option(o.overrides);
  options.json_flag(o.json);
}

}  // namespace firn
