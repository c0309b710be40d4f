// RunHosts holds the other computers of a print: starts the processes there, watches the relays, and collects
// their records when the print is over.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "print/hosts/remote_host.h"

namespace firn {

class RunHosts {
 public:
  /// @param nodes all of the print
  RunHosts(const Experiment& experiment, const runs::RunFolder& run, const std::vector<std::string>& nodes);

  bool empty() const { return orders_.empty(); }
  bool has(const std::string& node) const;
  /// Starts the relays. Notes in the run folder that the records are not here yet.
  /// @returns the processes there
  std::vector<std::unique_ptr<NodeProcess>> start(const std::filesystem::path& programs,
                                                  const ProcessArgs& args, const std::string& key_line);
  void add_to(std::vector<pollfd>& fds);
  void service();
  bool ready() const;
  /// Returns why a relay has ended though the print goes on; empty: none has.
  std::string lost();
  /// Processes "relay_NAME" and their pids.
  std::map<std::string, int> pids() const;
  /// Waits until the records of all hosts that can be reached are here. The processes there are killed if
  /// they still run.
  /// @param turn waits for a while for something to happen, and false ends the wait
  void collect(const std::function<bool()>& turn);

 private:
  const runs::RunFolder& run_;
  std::vector<relay::HostOrder> orders_;
  std::vector<std::unique_ptr<RemoteHost>> hosts_;
};

/// Fetches the records that a print left on its hosts, fills the log from them and seals the run anew. Does
/// nothing where all are here. The caller holds the run (run_lock.h).
/// @param programs the folder of the processes' programs
/// @throws UsageError naming the host, and why its records cannot be had
void collect_records(const runs::RunFolder& run, const std::filesystem::path& programs,
                     const std::function<void(const std::string&)>& note);

}  // namespace firn
