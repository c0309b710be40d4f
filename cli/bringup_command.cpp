// run_bringup carries out the hardware checklist on a lab's instruments and keeps the findings.
#include "cli/commands.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "config/assumptions.h"
#include "config/devices.h"
#include "config/labs.h"
#include "core/options/number.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/bringup/bringup.h"
#include "print/bringup/far_instruments.h"
#include "print/device/lab_experiment.h"
#include "print/device/simulated_instruments.h"
#include "print/inputs/driver_input.h"
#include "print/interrupt.h"

namespace firn {
namespace {

struct BringupOptions {
  std::string lab;                     ///< lab or experiment file
  std::string node;                    ///< only this instrument; empty: all
  int row = -1;                        ///< only this row; -1: all
  bool again = false;                  ///< also rows that are done
  std::vector<std::string> answers;    ///< ROW=yes, ROW=no: instead of asking
  std::string result;                  ///< file; empty: LAB.bringup.json
  std::vector<std::string> overrides;  ///< --set KEY=VALUE
  bool json = false;
};

std::map<int, bool> answers_of(const std::vector<std::string>& texts) {
  std::map<int, bool> answers;
  for (const std::string& text : texts) {
    const std::size_t at = text.find('=');
    const std::optional<int> row = whole_number<int>(std::string_view(text).substr(0, at));
    const std::string said = at == text.npos ? "" : text.substr(at + 1);
    if (!row || (said != "yes" && said != "no"))
      throw UsageError("--answer " + text + ": must be ROW=yes or ROW=no");
    answers[*row] = said == "yes";
  }
  return answers;
}

std::optional<bool> ask_terminal(const std::string& question) {
  if (!::isatty(STDIN_FILENO)) return std::nullopt;
  for (std::string line;;) {
    fmt::print(stderr, "  {} [y/n, empty: later] ", question);
    if (!std::getline(std::cin, line) || line.empty()) return std::nullopt;
    if (line == "y" || line == "yes") return true;
    if (line == "n" || line == "no") return false;
  }
}

void show_bringup(const BringupResult& r) {
  fmt::print("{:<7} {:>2} {:<14} {}\n", r.state, r.id, r.node, r.what);
  if (!r.measured.empty())
    fmt::print("           {}{}\n", r.measured, r.limit.empty() ? "" : "; wanted: " + r.limit);
  if (r.state != "ok" && !r.mend.empty()) fmt::print("           {}\n", r.mend);
}

std::vector<std::string> words_for_hosts(const BringupOptions& o) {
  std::vector<std::string> words;
  if (o.row >= 0) words = {"--row", std::to_string(o.row)};
  for (const std::string& answer : o.answers) words.insert(words.end(), {"--answer", answer});
  return words;
}

/// @returns 0 no row has failed, 1 one has
int run_bringup(const Product& product, const BringupOptions& o) {
  const Experiment e = load_lab_experiment(o.lab, o.overrides);
  const std::string file = o.result.empty() ? bringup_file(o.lab) : o.result;
  const std::string configuration = bringup_configuration(e);
  BringupState state = read_bringup(file).value_or(BringupState{});
  if (state.configuration != configuration) state = {configuration, {}, {}};

  const auto outside = with_driver_files(outside_ports(e), e, std::filesystem::path(o.lab).parent_path());
  std::optional<SimulatedInstruments> world;
  if (!simulated_ports(e).empty()) world.emplace(e);
  const auto answers = answers_of(o.answers);
  const InterruptGuard guard;
  BringupLab lab(
      product, e,
      [&](const std::string& node) {
        const auto at = outside.find(node);
        return at != outside.end() ? at->second : world->address(node);
      },
      [&](int row, const std::string& question) -> std::optional<bool> {
        if (const auto at = answers.find(row); at != answers.end()) return at->second;
        return o.json ? std::nullopt : ask_terminal(question);
      },
      [] { return InterruptGuard::raised(); });
  if (!o.json) fmt::print("{}\n", ports_text(e));
  if (o.node != "" && !lab.has(o.node)) throw UsageError("the lab has no instrument '" + o.node + "'");

  FarRows far(e, words_for_hosts(o));
  std::vector<std::string> nodes;
  for (const LabProcess& p : lab_of(e).processes)
    if (lab.has(p.node) && (o.node.empty() || p.node == o.node)) nodes.emplace_back(p.node);
  int failed = 0, done = 0, open = 0;
  std::vector<std::string> dead;  // whose link row failed: nothing more of them is tried
  for (const PlannedRow& planned : planned_rows(e)) {
    if (InterruptGuard::raised()) break;
    if ((!o.node.empty() && planned.node != o.node) || (o.row >= 0 && planned.row->id != o.row)) continue;
    const auto same = [&](const BringupResult& r) {
      return r.id == planned.row->id && r.node == planned.node;
    };
    const auto at = std::ranges::find_if(state.rows, same);
    const std::string port = port_of(e, planned.node);
    const bool kept = at != state.rows.end() && at->state == "ok" && at->port == port && !o.again;
    BringupResult r = kept ? *at : BringupResult{};
    if (!kept && std::ranges::find(dead, planned.node) != dead.end())
      r = {planned.row->id,
           planned.node,
           std::string(planned.row->what),
           "open",
           planned.row->check != nullptr,
           "not carried out: its link has failed",
           "",
           "",
           0.0,
           port};
    else if (!kept)
      r = far.has(planned) ? far.row(planned) : carry_out(planned, lab);
    if (r.id == 0 && r.state == "failed") dead.push_back(r.node);
    failed += r.state == "failed";
    done += r.state == "ok";
    open += r.state == "open";
    if (!o.json) show_bringup(r);
    if (at != state.rows.end())
      *at = r;
    else
      state.rows.push_back(r);
    for (const auto& [node, identity] : lab.identities) state.identities[node] = identity;
    for (const auto& [node, identity] : far.identities()) state.identities[node] = identity;
    write_bringup(file, state);  // a row that was done stays done, whatever comes
  }
  if (o.json) {
    std::puts(nlohmann::ordered_json{{"file", file},
                                     {"configuration", configuration},
                                     {"identities", state.identities},
                                     {"ports", ports_text(e)},
                                     {"ok", done},
                                     {"failed", failed},
                                     {"open", open},
                                     {"assumptions", assumptions_json(e, nodes)},
                                     {"rows", to_json(state.rows)}}
                  .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)
                  .c_str());
  } else {
    for (const std::string& node : nodes)
      if (const std::string text = assumptions_text(e, node); !text.empty())
        fmt::print("{}: {}\n", node, text);
    fmt::print("{} ok, {} failed, {} open; {}\n", done, failed, open, file);
  }
  return InterruptGuard::raised() ? kInterrupted : failed > 0 ? kFailed : kOk;
}

}  // namespace

void declare_bringup(OptionSet& options) {
  auto& o = options.calls(&run_bringup);
  options.option("LAB", o.lab, "lab or experiment file").required();
  options.option("--device", o.node, "only this instrument");
  options.option("--row", o.row, "only this row");
  options.flag("--again", o.again, "also rows that are done");
  options.option("--answer", o.answers, "ROW=yes or ROW=no, instead of asking").one_value_each();
  options.option("--result", o.result, "file of the results; default: LAB.bringup.json");
  options.override_option(o.overrides);
  options.json_flag(o.json);
}

}  // namespace firn
