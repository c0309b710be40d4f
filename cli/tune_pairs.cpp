#include "cli/tune_pairs.h"

#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <system_error>

#include "files/digest.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "studies/compare/study_runner.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path settings_file(const TuneLabOptions& o) { return fs::path(o.study.output) / "settings.json"; }

// The digest of all that decides the settings: the question, the runs, the build.
std::string question(const TunedRuns& tuned) {
  const TuneLabOptions& o = tuned.options;
  std::string all = study_origin().build + "\n" + digest_of(tuned.start.experiment, tuned.start.inputs);
  for (const tune::RecordedRun& run : tuned.runs) {
    all += "\n" + digest_of(run.experiment, run.inputs);
    for (const double feature : run.features) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &feature, sizeof bits);
      all += " " + std::to_string(bits);
    }
  }
  for (const std::string& key : o.keys) all += "\n" + key;
  all += "\n" + o.goal + "\n" + std::to_string(o.budget) + "\n" + std::to_string(o.seed) + "\n" +
         std::to_string(o.verify);
  return sha256_hex(std::as_bytes(std::span(all)));
}

}  // namespace

std::optional<tune::PairSettings> remembered_settings(const TunedRuns& tuned) {
  const fs::path file = settings_file(tuned.options);
  if (tuned.options.study.output.empty() || !fs::exists(file)) return std::nullopt;
  try {
    const Json j = Json::parse(read_file(file));
    if (j.at("question") != question(tuned)) return std::nullopt;
    tune::PairSettings s{j.at("old").get<tune::Setting>(), j.at("new").get<tune::Setting>(),
                         tuned.options.verify, tuned.options.seed};
    if (s.old_setting.size() != tuned.keys.size() || s.new_setting.size() != tuned.keys.size())
      throw UsageError(file.string() + ": is of another number of keys");
    return s;
  } catch (const Json::exception& error) {
    throw UsageError(file.string() + ": is no record of settings: " + error.what());
  }
}

void remember_settings(const TunedRuns& tuned, const tune::PairSettings& settings) {
  const fs::path file = settings_file(tuned.options);
  if (tuned.options.study.output.empty()) return;
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) throw UsageError(file.parent_path().string() + ": cannot be made: " + error.message());
  Json keys = Json::array();
  for (const tune::TuneKey& key : tuned.keys) keys.push_back(key.key());
  write_file_atomically(file, Json{{"question", question(tuned)},
                                   {"keys", keys},
                                   {"old", settings.old_setting},
                                   {"new", settings.new_setting}}
                                      .dump(2) +
                                  "\n");
}

std::vector<std::string> pair_words(const TuneLabOptions& o) {
  std::vector<std::string> words{fs::read_symlink("/proc/self/exe").string(), "tune"};
  for (const std::string& run : o.runs) words.push_back(fs::absolute(run).string());
  const auto add = [&](const std::string& option, const std::string& value) {
    words.push_back(option);
    words.push_back(value);
  };
  std::string keys;
  for (const std::string& key : o.keys) keys += (keys.empty() ? "" : ",") + key;
  add("--keys", keys);
  for (const std::string& assignment : o.overrides) add("--set", assignment);
  add("--goal", o.goal);
  add("--budget", std::to_string(o.budget));
  add("--verify", std::to_string(o.verify));
  add("--seed", std::to_string(o.seed));
  add("--study", fs::absolute(o.study.output).string());
  if (o.unsealed) words.push_back("--unsealed");
  if (o.run_python) words.push_back("--run-python");
  return words;
}

}  // namespace firn
