// Study holds the prints to compare, read from TOML; every override goes through the table of configuration
// fields.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/experiment.h"
#include "config/worlds.h"

namespace firn {

/// A named change of the base experiment.
struct StudyEntry {
  std::string name;
  std::vector<std::string> overrides;  ///< "control.scheme=mpc", as of --set
  int line = 0;                        ///< in the study file; 0 = not written there
  std::vector<std::string> runs = {};  ///< on record, relative to the study file; else it is printed
  std::vector<KeyRange> priors = {};   ///< of a part that is a declared world: of the labs of its seeds
  std::string source = {};             ///< likewise
};

/// The declared worlds that are a study's parts.
struct StudyWorlds {
  std::string file;  ///< relative to the study file; empty: they are not
  LabSet use = LabSet::kTuning;
  std::string name;  ///< of the declaration
  std::vector<DeclaredGoal> goals;
};

/// Design of a comparison: an arm is a scheme under one combination of the varied keys. Every arm prints
/// every part, once per seed; a seed has one lab, whatever the arm.
struct Study {
  std::string file;                    ///< for messages
  std::string name;                    ///< of the study folder
  std::string experiment;              ///< file or run folder, relative to the study file; "" = the defaults
  std::filesystem::path lab;           ///< file whose lab replaces that of the experiment; empty: its own
  std::vector<std::string> overrides;  ///< for every print
  std::vector<StudyEntry> arms;        ///< schemes x vary, in order
  std::vector<StudyEntry> parts;       ///< one unnamed part if the file lists none
  std::vector<std::uint64_t> seeds;
  std::vector<KeyRange> priors;      ///< of the lab of each seed
  std::vector<std::string> metrics;  ///< the first is the primary one; "" = the lab's own
  std::string baseline;              ///< an arm's name, or ""
  std::string judged;                ///< an arm's name, or ""
  double margin = 1.1;               ///< of the judged arm, above 1
  StudyWorlds worlds = {};

  /// Returns true if the schemes are runs on record: all of them are then, with as many runs each.
  bool recorded() const { return !arms.empty() && !arms.front().runs.empty(); }
};

inline constexpr std::size_t kMaxArms = 64, kMaxParts = 64, kMaxSeeds = 100'000, kMaxPrints = 1'000'000;

/// Keys: name, experiment, set, seeds (a count n = 1..n, or a list), metrics, baseline, judged, margin;
/// [[scheme]] and
/// [[part]] with name and set; [vary], [zip], [sample] and [prior] (config/study_design.h). Or [[scheme]]
/// with name and runs, name, metrics, baseline and nothing else. Or worlds and labs, the file of a
/// declaration and one of its kinds of labs, with which load_study() fills experiment, parts, seeds and
/// metrics. @throws ConfigError naming file, line, key and limit.
Study parse_study(std::string_view toml_text, const std::string& file_name);

/// parse_study of the file at `path`. @throws ConfigError, also if it cannot be read
Study load_study(const std::filesystem::path& path);

/// Returns the file of the study's experiment; that of a run folder is experiment.toml.
std::filesystem::path study_experiment_file(const Study& study, const std::filesystem::path& folder);

/// Returns the texts of the study's experiment from base to leaf, as read_with_includes; with a lab of the
/// study its texts stand where those that the experiment includes were. @throws ConfigError: also if the
/// experiment includes no lab that could be replaced
std::vector<std::pair<std::string, std::string>> study_texts(const Study& study,
                                                             const std::filesystem::path& folder);

/// Returns the experiments of every arm on every part (arm-major), with unchanged seeds. `folder` = of the
/// study file.
/// @throws ConfigError: the message of load_experiment, preceded by the names of arm and part.
std::vector<Experiment> study_experiments(const Study& study, const std::filesystem::path& folder);

}  // namespace firn
