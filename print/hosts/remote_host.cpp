#include "print/hosts/remote_host.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "core/options/number.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> relay_arguments(ProcessArgs args, bool collect) {
  args.options.node = NodeId::kLauncher;
  args.options.control_fd = ChildProcess::kControlFd;
  args.options.faults = {};
  args.options.record = false;
  args.options.real_ports.clear();
  args.blobs.clear();
  if (collect) args.bus_url = "-";
  return to_arguments(args);
}

}  // namespace

class RemoteHost::Process : public NodeProcess {
 public:
  Process(std::string node, RemoteHost& host, State& state)
      : NodeProcess(std::move(node)), host_(host), state_(state) {}
  pid_t pid() const override { return state_.pid; }
  void say(std::string_view line) override { host_.relay_.say("TO " + name() + " " + std::string(line)); }
  std::optional<std::string> next() override {
    host_.service();
    if (state_.lines.empty()) return std::nullopt;
    std::string line = std::move(state_.lines.front());
    state_.lines.pop_front();
    return line;
  }
  void add_to(std::vector<pollfd>&) override {}  // its lines come by the relay
  const std::optional<Ending>& poll_ending() override {
    host_.service();
    if (!state_.ending && !host_.relay_.running()) state_.ending = Ending{};
    return state_.ending;
  }
  void kill() override {}  // its host does, once it is told to collect

 private:
  RemoteHost& host_;
  State& state_;
};

RemoteHost::RemoteHost(relay::HostOrder order, const fs::path& relay, ProcessArgs args,
                       const std::string& key_line)
    : order_(std::move(order)),
      relay_("relay_" + order_.name, relay, relay_arguments(args, key_line.empty()),
             RunPaths(args.options.run_dir).nodes_path() / ("relay_" + order_.name + ".err")) {
  fs::create_directories(RunPaths(args.options.run_dir).hosts_path());
  if (!key_line.empty()) relay_.say(key_line);
  args.options.node = NodeId::kScheduler;  // the host names each process
  args.bus_url = args.bus_url.empty() ? "-" : args.bus_url;
  order_.arguments = to_arguments(args);
  relay_.say(to_json(order_));
  for (const std::string& node : order_.nodes) states_.try_emplace(node);
}

std::unique_ptr<NodeProcess> RemoteHost::process(const std::string& node) {
  return std::make_unique<Process>(node, *this, states_.at(node));
}

void RemoteHost::service() {
  while (const auto line = relay_.next()) {
    std::istringstream words(*line);
    std::string verb, node;
    words >> verb;
    if (verb == "READY") {
      ready_ = true;
    } else if (verb == "COLLECTED") {
      collected_ = true;
    } else if (verb == "FROM" && words >> node >> std::ws && states_.contains(node)) {
      std::string rest;
      std::getline(words, rest);
      states_[node].lines.push_back(rest);
    } else if (verb == "ENDED" && words >> node && states_.contains(node)) {
      Ending ending;
      if (words >> ending.code >> ending.signal) states_[node].ending = ending;
    } else if (verb == "BUS") {
      words >> bus_url_;
    } else if (verb == "PIDS") {
      for (std::string pair; words >> pair;) {
        const std::size_t equals = std::min(pair.find('='), pair.size() - 1);
        const auto at = states_.find(pair.substr(0, equals));
        if (const auto pid = whole_number<pid_t>(std::string_view(pair).substr(equals + 1));
            pid && at != states_.end())
          at->second.pid = *pid;
      }
    } else if (verb == "CLOCK") {
      double ahead_ns = 0.0, bound_ns = 0.0;
      if (words >> ahead_ns >> bound_ns) clock_bound_ms_ = bound_ns * 1e-6;
    } else if (verb == "ERROR" || verb == "FAULT") {
      trouble_ = line->substr(verb.size() + 1);
    }
  }
}

relay::HostOrder order_for(const runs::RunFolder& run, const std::string& host,
                           const relay::HostPlace& place) {
  relay::HostOrder o;
  o.name = host;
  o.address = place.address;
  o.program = place.program;
  o.run_id = run.run_id();
  o.run = run.path().lexically_normal().filename().string();
  o.place = fs::absolute(run.path()).string();
  return o;
}

std::vector<relay::HostOrder> host_orders(const Experiment& e, const runs::RunFolder& run,
                                          const std::vector<std::string>& nodes) {
  std::vector<relay::HostOrder> orders;
  for (const auto& [name, address] : e.hosts.address) {
    relay::HostOrder o = order_for(run, name, relay::place_of(address));
    o.slack_ms = e.run.clock_slack_ms;
    o.silence_s = e.run.lease_s + kSilentBeyondLeaseS;
    for (const std::string& node : nodes)
      if (const auto host = e.hosts.of_node.find(node); host != e.hosts.of_node.end() && host->second == name)
        o.nodes.push_back(node);
    if (!o.nodes.empty()) orders.push_back(std::move(o));
  }
  return orders;
}

std::map<std::string, relay::FileState> files_for(const runs::RunFolder& run, const relay::HostOrder& order) {
  std::vector<std::string> names{RunPaths::kExperiment, RunPaths::kProvenance};
  if (order.collect) names.clear();
  if (!order.collect)
    for (const auto& [role, sha] : run.input_digests())
      names.push_back(std::string(RunPaths::kInputs) + "/" + sha);
  for (const std::string& node : order.nodes)
    for (const std::string& name : relay::grown_by(node)) names.push_back(name);
  std::map<std::string, relay::FileState> files;
  for (const std::string& name : names)
    if (relay::FileState state = relay::state_of(run.path() / name); state.bytes >= 0)
      files[name] = std::move(state);
  return files;
}

}  // namespace firn
