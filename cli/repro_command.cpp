// run_repro checks a bundle, replays its runs and prints them again.
#include "cli/commands.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/print_again.h"
#include "cli/replay_command.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/temporary_folder.h"
#include "files/usage_error.h"
#include "replay/print_verdict.h"
#include "runs/bundle/bundle.h"
#include "runs/folder/seal_check.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

struct ReproOptions {
  std::string file;
  std::string keep;       ///< empty folder for the runs; empty: none stays
  bool trust = false;     ///< runs Python code of the bundle
  bool no_print = false;  ///< checks and replays alone
  bool json = false;
};

// A folder that goes at the end, unless it is to stay.
class Unpacked {
 public:
  explicit Unpacked(const std::string& keep) : path_(keep) {
    if (!keep.empty()) {
      std::error_code error;
      fs::create_directories(path_, error);
      if (error || !fs::is_empty(path_)) throw UsageError("--keep " + keep + ": an empty folder is wanted");
      return;
    }
    path_ = goes_.emplace("repro").path();
  }

  fs::path folder(const char* name) const {
    const fs::path folder = path_ / name;
    fs::create_directory(folder);
    return folder;
  }

 private:
  std::optional<TemporaryFolder> goes_;
  fs::path path_;
};

struct ReproVerdict {
  std::string name, seal, replay, print;
  bool good = true;  ///< each step as it must be
};

// The first difference in words.
std::string first_reason(const replay::RunVerdict& v) {
  if (!v.altered.empty()) return v.altered.front();
  const auto text = replay::to_text(v);
  std::string first;
  for (std::size_t at = 0; at < text.size() && first.size() < 300;) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    if (!line.empty()) first += (first.empty() ? "" : " | ") + line;
  }
  return first;
}

ReproVerdict repro_run(const Product& product, const runs::BundledRun& run, const ReproOptions& o,
                       const fs::path& scratch) {
  ReproVerdict v;
  v.name = run.name;
  const runs::SealCheck seals = runs::check_seals(run.folder);
  v.seal = seals.lines().empty() ? seals.summary() : "is not as it was sealed: " + seals.lines().front();
  if (seals.seals.empty() || !seals.lines().empty()) {
    v.good = false;
    v.replay = v.print = "not tried";
    return v;
  }
  ReplayCommandOptions replay;
  replay.run = run.folder.string();
  replay.run_python = o.trust ? replay::RunPython::kAlways : replay::RunPython::kNever;
  const replay::RunVerdict verdict = replay_verdict(product, replay);
  v.replay = verdict.identical() ? "identical" : first_reason(verdict);
  for (const replay::NodeVerdict& n : verdict.not_replayed)
    v.replay += "; " + n.name + " was not replayed: it is Python code of the bundle (" + n.python +
                "), which --trust runs";
  v.good = verdict.identical();
  if (o.no_print) {
    v.print = "not tried";
    return v;
  }
  const PrintedAgain again = print_again(product, run.folder, scratch, o.trust);
  v.print = again.same ? "same bytes, " + std::to_string(again.messages) + " messages" : again.why;
  v.good = v.good && (again.same || !again.printed);
  return v;
}

int run_repro(const Product& product, const ReproOptions& o) {
  const Unpacked place(o.keep);
  const std::vector<runs::BundledRun> found = runs::unpack_bundle(o.file, place.folder("runs"));
  const fs::path scratch = place.folder("again");
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  bool good = true;
  for (const runs::BundledRun& run : found) {
    const ReproVerdict v = repro_run(product, run, o, scratch);
    good = good && v.good;
    if (o.json)
      all.push_back(
          {{"run", v.name}, {"good", v.good}, {"seal", v.seal}, {"replay", v.replay}, {"print", v.print}});
    else
      fmt::print("{}\n    files: as the metadata says\n    {}\n    replay: {}\n    printed again: {}\n",
                 v.name, v.seal, v.replay, v.print);
  }
  if (o.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"file", o.file}, {"good", good}, {"runs", all}}.dump(
                           2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  return good ? kOk : kFailed;
}

}  // namespace

void declare_repro(OptionSet& options) {
  auto& o = options.calls(run_repro);
  options.option("FILE", o.file, "bundle of firn bundle").required();
  options.flag("--trust", o.trust, "run the Python code in the bundle; docs/security.md");
  options.flag("--no-print", o.no_print, "check and replay, and do not print again");
  options.option("--keep", o.keep, "empty folder where the unpacked runs and the new prints stay");
  options.json_flag(o.json);
}

}  // namespace firn
