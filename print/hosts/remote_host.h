// RemoteHost is another computer of a run as its launcher sees it: the relay to it, and the processes there.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/process/child_process.h"
#include "procs/relay/hello.h"
#include "runs/folder/run_folder.h"
#include "runtime/process_args.h"

namespace firn {

class RemoteHost {
 public:
  /// Starts the relay, and by it the processes of `order`.
  /// @param relay its program
  /// @param args of a process of the run here; @param key_line of the bus; empty: only collects
  RemoteHost(relay::HostOrder order, const std::filesystem::path& relay, ProcessArgs args,
             const std::string& key_line);

  const std::string& name() const { return order_.name; }
  /// Makes the process of a node there. This host must live longer.
  std::unique_ptr<NodeProcess> process(const std::string& node);

  /// The relay, whose end is the end of all that is there.
  NodeProcess& relay() { return relay_; }
  /// Sorts the relay's lines since the last call.
  void service();
  bool ready() const { return ready_; }
  bool collected() const { return collected_; }            ///< all records that were made there are here
  const std::string& trouble() const { return trouble_; }  ///< its ERROR or FAULT
  double clock_bound_ms() const { return clock_bound_ms_; }
  const std::string& bus_url() const { return bus_url_; }  ///< on the loopback there

 private:
  class Process;
  struct State {
    std::deque<std::string> lines;
    std::optional<Ending> ending;
    pid_t pid = 0;
  };

  relay::HostOrder order_;
  ChildProcess relay_;
  std::map<std::string, State> states_;
  std::string trouble_, bus_url_;
  bool ready_ = false, collected_ = false;
  double clock_bound_ms_ = 0.0;
};

/// A host that has said nothing for so long beyond the lease is lost: its instruments are safe by then.
inline constexpr double kSilentBeyondLeaseS = 0.2;
/// Returns the order for a host of the run, without nodes, files and arguments.
relay::HostOrder order_for(const runs::RunFolder& run, const std::string& host,
                           const relay::HostPlace& place);

/// Returns the orders for the hosts that the experiment names, each with the nodes of `nodes` that run there,
/// and without files and arguments.
std::vector<relay::HostOrder> host_orders(const Experiment& experiment, const runs::RunFolder& run,
                                          const std::vector<std::string>& nodes);
/// The files of the run that a host needs: configuration, provenance, inputs, and its nodes' records.
std::map<std::string, relay::FileState> files_for(const runs::RunFolder& run, const relay::HostOrder& order);

}  // namespace firn
