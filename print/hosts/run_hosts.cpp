#include "print/hosts/run_hosts.h"

#include <poll.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "config/devices.h"
#include "files/usage_error.h"
#include "print/run_facts.h"
#include "runs/folder/host_record.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/log_repair.h"
#include "runtime/process_args.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
constexpr int kTurnMs = 200;

runs::HostRecord record_of(const relay::HostOrder& o, bool complete) {
  return {o.name, o.address, o.program, o.nodes, complete};
}

}  // namespace

RunHosts::RunHosts(const Experiment& e, const runs::RunFolder& run, const std::vector<std::string>& nodes)
    : run_(run), orders_(host_orders(e, run, nodes)) {
  const auto simulated = simulated_ports(e);
  for (relay::HostOrder& o : orders_)
    std::ranges::copy_if(o.nodes, std::back_inserter(o.simulated), [&](const auto& node) {
      return std::ranges::find(simulated, node) != simulated.end();
    });
}

bool RunHosts::has(const std::string& node) const {
  return std::ranges::any_of(
      orders_, [&](const auto& o) { return std::ranges::find(o.nodes, node) != o.nodes.end(); });
}

std::vector<std::unique_ptr<NodeProcess>> RunHosts::start(const fs::path& programs, const ProcessArgs& args,
                                                          const std::string& key_line) {
  if (!empty() && key_line.empty())
    throw UsageError("a print with processes on other hosts needs a bus with a key: --bus without key=none");
  std::vector<std::unique_ptr<NodeProcess>> processes;
  for (relay::HostOrder& o : orders_) {
    o.files = files_for(run_, o);
    runs::write_host_record(run_.path(), record_of(o, false));
    hosts_.push_back(std::make_unique<RemoteHost>(o, programs / "relay", args, key_line));
    for (const std::string& node : o.nodes) processes.push_back(hosts_.back()->process(node));
  }
  return processes;
}

void RunHosts::add_to(std::vector<pollfd>& fds) {
  for (const auto& h : hosts_) h->relay().add_to(fds);
}

void RunHosts::service() {
  for (const auto& h : hosts_) h->service();
}

bool RunHosts::ready() const {
  return std::ranges::all_of(hosts_, [](const auto& h) { return h->ready(); });
}

std::string RunHosts::lost() {
  for (const auto& h : hosts_) {
    const auto& ending = h->relay().poll_ending();
    if (!ending || h->collected()) continue;
    h->service();
    return h->trouble().empty() ? h->relay().name() + " " + to_text(*ending) : h->trouble();
  }
  return "";
}

std::map<std::string, int> RunHosts::pids() const {
  std::map<std::string, int> pids;
  for (const auto& h : hosts_) pids[h->relay().name()] = int(h->relay().pid());
  return pids;
}

void RunHosts::collect(const std::function<bool()>& turn) {
  for (const auto& h : hosts_) h->relay().say("STOP");
  const auto waits = [](const auto& h) { return h->relay().running(); };
  while (std::ranges::any_of(hosts_, waits) && turn()) service();
  service();
  for (std::size_t n = 0; n < hosts_.size(); ++n)
    if (hosts_[n]->collected()) runs::write_host_record(run_.path(), record_of(orders_[n], true));
}

void collect_records(const runs::RunFolder& run, const fs::path& programs,
                     const std::function<void(const std::string&)>& note) {
  std::vector<runs::HostRecord> wanted = runs::host_records(run.path());
  std::erase_if(wanted, [](const runs::HostRecord& r) { return r.complete; });
  if (wanted.empty()) return;
  const runs::SealCheck before = runs::check_seals(run.path());
  for (const runs::HostRecord& r : wanted) {
    relay::HostOrder o = order_for(run, r.name, {r.address, r.program});
    o.nodes = r.nodes;
    o.collect = true;
    o.files = files_for(run, o);
    note("collecting the records of host " + r.name);
    ProcessArgs args;
    args.options.run_dir = run.path().string();
    args.options.run_id = run.run_id();
    RemoteHost host(o, programs / "relay", args, "");
    while (host.relay().running()) {
      std::vector<pollfd> fds;
      host.relay().add_to(fds);
      ::poll(fds.data(), nfds_t(fds.size()), kTurnMs);
      host.service();
    }
    host.service();
    if (!host.collected())
      throw UsageError(run.path().string() + ": the records of host " + r.name + " are not here: " +
                       (host.trouble().empty() ? host.relay().name() + " failed" : host.trouble()));
    runs::write_host_record(run.path(), record_of(o, true));
  }
  runs::repair_from_write_ahead(run.log_path(), run.nodes_path());
  if (std::optional<runs::RunResult> result = run.result()) {  // its audit was of fewer records
    add_facts(run, parse_experiment(run.experiment_toml(), run.experiment_path().string()), *result);
    run.write_result(*result);
  }
  runs::seal_repaired(run.path(), before);
}

}  // namespace firn
