#include "cli/print_again.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "config/devices.h"
#include "config/experiment.h"
#include "core/options/number.h"
#include "files/record/checksum.h"
#include "files/run_paths.h"
#include "lcmtypes/channels.h"
#include "print/import/imported_run.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/origin.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/seal_check.h"
#include "runs/read/run_log.h"
#include "runtime/build_info.h"
#include "runtime/result_fingerprint.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct LoggedMessage {
  std::string channel;
  std::int64_t utime_us = 0;
  std::uint64_t sum = 0;  // of the bytes
};

std::vector<LoggedMessage> logged(const fs::path& run) {
  std::vector<LoggedMessage> all;
  runs::each_message(
      run,
      [&](const record::Event& e, const schema::Type&) {
        all.push_back({std::string(e.channel), e.utime_us, record::checksum64(e.data)});
      },
      [](double) {});
  return all;
}

std::vector<std::string> option_values(const std::vector<std::string>& words, std::string_view name) {
  std::vector<std::string> values;
  for (std::size_t n = 0; n < words.size(); ++n)
    if (words[n] == name && n + 1 < words.size())
      values.push_back(words[n + 1]);
    else if (words[n].starts_with(std::string(name) + "="))
      values.push_back(words[n].substr(name.size() + 1));
  return values;
}

// The reason for which no program could print a run again; empty: there is none.
std::string hindrance(const fs::path& run, const runs::RunFolder& folder, const Experiment& e,
                      const runs::ProvenanceDocument& provenance, bool run_python) {
  if (is_imported(run)) return "it is a record of others: nothing was printed by Firn";
  if (!outside_ports(e).empty())
    return "it was printed with instruments that are not simulated: " + ports_text(e);
  if (const std::string python = runs::python_of(folder.experiment_toml(), "");
      !python.empty() && !run_python)
    return "it has Python code, which --trust runs: " + python;
  const auto result = folder.result();
  if (!result || runs::can_go_on(*result)) return "it did not end";
  for (const runs::Seal& seal : runs::check_seals(run).seals)
    if (seal.incarnation > 0) return "it was interrupted and resumed";
  const auto bus = option_values(provenance.command_line, "--bus");
  if (bus.empty() || bus.back() != "in-process")
    return "it was printed live: its messages have the times of a clock, which comes but once";
  return "";
}

std::string cause_of(const runs::ProvenanceDocument& provenance) {
  if (const std::string commit = provenance.text("commit"); commit != build_commit())
    return "; it was printed by commit " + commit + ", and this is " + build_commit();
  const auto functions = differing_functions(provenance.results, result_fingerprint());
  return functions.empty() ? "" : "; function " + functions.front() + " gives other results on this computer";
}

// An equal place of its own for the new print: same number, same inputs, no record.
void prepare(const fs::path& run, const fs::path& again) {
  const RunPaths from(run), to(again);
  for (const fs::path& folder : {to.nodes_path(), to.ports_path(), to.world_path()})
    fs::create_directories(folder);
  fs::copy_file(from.experiment_path(), to.experiment_path());
  fs::copy_file(from.provenance_path(), to.provenance_path());
  fs::copy(from.inputs_path(), to.inputs_path(), fs::copy_options::recursive);
}

}  // namespace

PrintedAgain print_again(const Product& product, const fs::path& run, const fs::path& scratch,
                         bool run_python) {
  PrintedAgain p;
  const runs::RunFolder folder = runs::RunFolder::open(run);
  const runs::ProvenanceDocument provenance = folder.provenance();
  const Experiment e = parse_recorded_experiment(folder.experiment_toml(), folder.experiment_path().string());
  p.why = hindrance(run, folder, e, provenance, run_python);
  if (!p.why.empty()) return p;
  const std::vector<LoggedMessage> before = logged(run);
  for (const LoggedMessage& m : before)
    if (m.channel == channels::kOperatorCommand.name) {
      p.why = "an operator commanded it while it printed";
      return p;
    }
  const fs::path again = scratch / fs::path(run).filename();
  prepare(run, again);
  LabRunOptions options;
  options.note = [](const std::string&) {};
  options.faults = parse_lab_faults(option_values(provenance.command_line, "--fault"), e);
  if (const auto tolerance = option_values(provenance.command_line, "--tolerance"); !tolerance.empty())
    options.tolerance_um = whole_number<double>(tolerance.back()).value_or(0.0);
  run_in_lab(product, runs::RunFolder::open(again), options);
  p.printed = true;
  const std::vector<LoggedMessage> after = logged(again);
  for (std::size_t n = 0; n < std::max(before.size(), after.size()); ++n) {
    const bool both = n < before.size() && n < after.size();
    if (both && before[n].channel == after[n].channel && before[n].utime_us == after[n].utime_us &&
        before[n].sum == after[n].sum) {
      ++p.messages;
      continue;
    }
    const LoggedMessage& m = n < before.size() ? before[n] : after[n];
    p.why = "message " + std::to_string(n) + ", " + m.channel + " at " +
            std::to_string(double(m.utime_us) * 1e-6) + " s, " +
            (both && before[n].channel == after[n].channel ? "has other bytes"
             : n < before.size()                           ? "does not come"
                                                           : "was not recorded") +
            cause_of(provenance);
    return p;
  }
  p.same = true;
  return p;
}

}  // namespace firn
