// run_bundle writes runs into one .eln file.
#include "cli/commands.h"

#include <fmt/core.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/progress.h"
#include "runs/bundle/bundle.h"
#include "runs/folder/address.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct BundleOptions {
  std::vector<std::string> runs;
  std::string output, license;
  bool json = false;
};

int run_bundle(const BundleOptions& o) {
  const fs::path file = o.output;
  if (file.extension() != ".eln") throw UsageError(o.output + ": a bundle's name ends in .eln");
  std::vector<fs::path> folders;
  for (const std::string& run : o.runs) folders.push_back(runs::folder_of(run));
  JobProgress progress("bundle");
  const runs::BundleReport report =
      runs::write_bundle(folders, file, o.license, [&](double fraction) { progress.show(fraction, ""); });
  progress.done();
  if (o.json)
    fmt::print(
        "{}\n",
        nlohmann::ordered_json{
            {"file", o.output}, {"runs", folders.size()}, {"files", report.files}, {"bytes", report.bytes}}
            .dump());
  else
    fmt::print("{}: {} runs, {} files, {:.1f} MB of files in {:.1f} MB\n", o.output, folders.size(),
               report.files, double(report.bytes) * 1e-6, double(fs::file_size(file)) * 1e-6);
  return kOk;
}

}  // namespace

void declare_bundle(OptionSet& options) {
  auto& o = options.calls(run_bundle);
  options.option("RUN", o.runs, "run folders, sealed").required();
  options.option("-o,--output", o.output, "FILE.eln").required();
  options.option("--license", o.license, "of the data: its address or its name, such as CC-BY-4.0");
  options.json_flag(o.json);
}

}  // namespace firn
