#include "cli/export_command.h"

#include <cstdio>
#include <deque>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/progress.h"
#include "report/export/run_mcap.h"
#include "report/export/run_tables.h"
#include "runs/folder/run_lock.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<report::TableSink> sink_of(const std::string& output) {
  const std::string ending = fs::path(output).extension().string();
  if (ending == ".h5" || ending == ".hdf5") return report::hdf5_sink(output);
  if (ending == ".npz") return report::npz_sink(output);
  if (ending == ".csv") return report::csv_sink(output);
  throw UsageError(output + ": no format with this ending; there are .h5, .npz, .mcap and .csv (a folder)");
}

std::string group_name(const fs::path& run) { return fs::weakly_canonical(run).filename().string(); }

}  // namespace

int run_export(const ExportOptions& options) {
  std::set<std::string> names;
  std::deque<runs::RunLock> still;
  for (const std::string& run : options.runs) {
    if (!names.insert(group_name(run)).second)
      throw UsageError(run + ": two runs have the name " + group_name(run) + ", which names their group");
    still.emplace_back(run, runs::RunUse::kRead);
  }
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  std::unique_ptr<report::McapExport> mcap;
  std::unique_ptr<report::TableSink> sink;
  if (fs::path(options.output).extension() == ".mcap")
    mcap = std::make_unique<report::McapExport>(options.output);
  else
    sink = sink_of(options.output);
  JobProgress progress("export");
  for (std::size_t k = 0; k < options.runs.size(); ++k) {
    const fs::path run = options.runs[k];
    const std::string prefix = options.runs.size() > 1 ? group_name(run) + "/" : "";
    const auto show = [&](double fraction) {
      progress.show((double(k) + fraction) / double(options.runs.size()), group_name(run));
    };
    const std::uint64_t messages =
        mcap ? mcap->add(run, prefix, show) : report::export_run(run, prefix, *sink, show);
    runs.push_back({{"run", run.string()}, {"messages", messages}});
  }
  mcap ? mcap->finish() : sink->finish();
  progress.done();
  if (options.json) {
    const nlohmann::ordered_json said = {{"file", options.output}, {"runs", runs}};
    std::puts(said.dump().c_str());
  } else {
    for (const auto& run : runs)
      std::printf("%s: %llu messages of %s\n", options.output.c_str(),
                  static_cast<unsigned long long>(run["messages"].get<std::uint64_t>()),
                  run["run"].get<std::string>().c_str());
  }
  return kOk;
}

void declare_export(OptionSet& options) {
  auto& o = options.calls(run_export);
  options.option("RUN", o.runs, "run folders; several become groups of one file").required();
  options.option("-o,--output", o.output, "FILE.h5, FILE.npz, FILE.mcap or FOLDER.csv").required();
  options.json_flag(o.json);
}

}  // namespace firn
