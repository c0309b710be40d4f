#include "print/folder/run_list.h"

#include <algorithm>
#include <sstream>

#include "files/json.h"
#include "files/lowercase.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/folder/run_folder.h"
#include "print/folder/run_pack.h"
#include "print/folder/running.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// A folder that cannot be read is listed with the reason.
RunEntry entry_of(const fs::path& folder) {
  RunEntry e;
  e.folder = folder;
  const auto pid = printing_process(folder);
  e.running = pid.has_value();
  try {
    const auto provenance = nlohmann::json::parse(read_file(folder / "provenance.json"));
    e.started_utc = provenance.value("started_utc", "");
    e.name = provenance.value("name", "");
    e.scheme = provenance.value("scheme", "");
    e.bytes = folder_bytes(folder);
    const auto result = RunFolder::open(folder).result();
    e.outcome = pid ? "running (pid " + std::to_string(*pid) + ")" : result ? result->outcome : "interrupted";
    if (result) {
      e.reason = result->reason;
      e.layers = result->layers;
    }
  } catch (const std::exception& error) {
    e.outcome = "unreadable";
    e.reason = error.what();
  }
  return e;
}

}  // namespace

std::vector<RunEntry> list_runs(const fs::path& root) {
  if (!fs::is_directory(root)) throw UsageError(root.string() + ": no such folder; --runs names another");
  std::vector<RunEntry> runs;
  for (const auto& entry : fs::directory_iterator(root))
    if (fs::exists(entry.path() / "provenance.json") && fs::exists(entry.path() / "experiment.toml") &&
        fs::is_directory(entry.path() / "nodes"))
      runs.push_back(entry_of(entry.path()));
  std::ranges::sort(runs, {}, [](const RunEntry& r) { return std::pair(r.started_utc, r.folder.string()); });
  return runs;
}

bool mentions(const RunEntry& run, const std::string& word) {
  std::string text = run.folder.filename().string() + "\n" + run.outcome + "\n" + run.reason;
  try {
    std::istringstream in(read_file(run.folder / "experiment.toml"));  // every key is in every experiment
    for (std::string line; std::getline(in, line);)
      if (const std::size_t equals = line.find('='); equals != line.npos)
        text += "\n" + line.substr(equals + 1);
  } catch (const std::exception&) {  // the list names it
  }
  return lowercase(text).find(lowercase(word)) != std::string::npos;
}

}  // namespace firn
