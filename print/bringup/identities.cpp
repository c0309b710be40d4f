// The instruments at the real ports, held against those of the bring-up.
#include <algorithm>
#include <future>

#include "config/devices.h"
#include "files/exit_codes.h"
#include "print/bringup/bringup.h"
#include "print/bringup/far_instruments.h"
#include "print/device/device_run.h"
#include "print/hosts/at_host.h"
#include "print/inputs/driver_input.h"

namespace firn {
namespace {

constexpr double kWithin_s = 20.0;  // a jet is started anew, which takes five

// As the link row of the bring-up there finds it.
DeviceReport who_answers_at(const Experiment& e, const std::string& host, const std::string& node) {
  constexpr const char* kLinkRow = "0";
  const BringupState told = rows_at_host(e, host, node, {"--row", kLinkRow});
  DeviceReport r;
  const auto identity = told.identities.find(node);
  const bool linked = !told.rows.empty() && told.rows[0].state == "ok" && identity != told.identities.end();
  r.status = linked ? kOk : kSafetyStop;
  r.text = linked              ? "done: " + identity->second
           : told.rows.empty() ? "host " + host + " has no such instrument"
                               : "at host " + host + ": " + told.rows[0].measured;
  return r;
}

DeviceReport who_answers(const Product& product, const Experiment& e, const std::string& node,
                         const PortAddress& address, const std::function<bool()>& interrupted) {
  DeviceJob job{product, e, node, &device_verb(node, "serial"), {}, false, kWithin_s};
  DeviceSinks sinks;
  sinks.interrupted = interrupted;
  try {
    if (const std::string host = host_of(e, node); !host.empty()) return who_answers_at(e, host, node);
    return run_verb(job, address, sinks);
  } catch (const std::runtime_error& error) {
    DeviceReport r;
    r.status = kSafetyStop;
    r.text = error.what();
    return r;
  }
}

}  // namespace

std::string identity_refusal(const Product& product, const Experiment& e, const std::filesystem::path& folder,
                             const BringupState& state, const std::string& file,
                             const std::vector<std::string>& accepted,
                             const std::function<bool()>& interrupted) {
  const auto accepts = [&](const std::string& what) {
    return std::ranges::any_of(accepted, [&](const std::string& a) { return a == "all" || a == what; });
  };
  struct Asked {
    std::string node, port;
    std::future<DeviceReport> report;
  };
  std::vector<Asked> asked;
  for (const auto& [node, address] : with_driver_files(real_ports(e), e, folder))
    if (!accepts(node + ":identity"))
      asked.push_back(
          {node, to_text(address),
           std::async(std::launch::async, [&product, &e, node = node, address = address, &interrupted] {
             return who_answers(product, e, node, address, interrupted);
           })});
  std::string why;
  for (Asked& a : asked) {
    const DeviceReport r = a.report.get();
    if (!why.empty()) continue;
    const auto known = state.identities.find(a.node);
    const std::string done = "done: ", told = r.text.starts_with(done) ? r.text.substr(done.size()) : r.text;
    if (known == state.identities.end())
      why = file + ": it does not name the " + a.node;
    else if (r.status != kOk)
      why = a.node + " at " + a.port + ": " + r.text;
    else if (told != known->second)
      why = "another instrument is at " + a.port + ": '" + told + "' answers, " + file +
            " was made with the " + a.node + " '" + known->second + "'";
    if (!why.empty())
      why += "; run ./firn bringup LAB --device " + a.node +
             " --again, or take the risk with --accept-bringup " + a.node + ":identity";
  }
  return why;
}

}  // namespace firn
