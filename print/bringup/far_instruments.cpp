#include "print/bringup/far_instruments.h"

#include <algorithm>

#include "files/command.h"
#include "files/json.h"
#include "print/hosts/at_host.h"

namespace firn {

BringupState rows_at_host(const Experiment& lab, const std::string& host, const std::string& node,
                          const std::vector<std::string>& words) {
  std::vector<std::string> all{"--device", node, "--json"};
  all.insert(all.end(), words.begin(), words.end());
  const CommandEnd end = run_command(words_at_host(lab, host, "bringup", all));
  try {
    return bringup_state_in(end.output);
  } catch (const std::invalid_argument&) {
    throw BringupStop("host " + host + ": " + end.reason() +
                      "; ssh must reach it without a password, and find the same firn there (docs/hosts.md)");
  }
}

bool FarRows::has(const PlannedRow& planned) const {
  return !host_of(lab_, planned.node).empty() && (planned.row->id == 0 || planned.row->check);
}

BringupResult FarRows::row(const PlannedRow& planned) {
  const auto [at, is_new] = told_.try_emplace(planned.node);
  Told& told = at->second;
  if (is_new) try {
      told.state = rows_at_host(lab_, host_of(lab_, planned.node), planned.node, words_);
    } catch (const BringupStop& e) {
      told.trouble = e.what();
    }
  const auto found = std::ranges::find(told.state.rows, planned.row->id, &BringupResult::id);
  if (found != told.state.rows.end()) {
    BringupResult r = *found;
    r.port = port_of(lab_, planned.node);
    return r;
  }
  BringupResult r{planned.row->id, planned.node, std::string(planned.row->what), "failed", true};
  r.measured = told.trouble.empty() ? "the host did not carry out this row" : told.trouble;
  r.mend = "mend this first, then run the row again";
  r.port = port_of(lab_, planned.node);
  return r;
}

std::map<std::string, std::string> FarRows::identities() const {
  std::map<std::string, std::string> all;
  for (const auto& [_, told] : told_) all.insert(told.state.identities.begin(), told.state.identities.end());
  return all;
}

}  // namespace firn
