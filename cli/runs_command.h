// The actions of firn runs beside the list: notes and tags of runs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runs/folder/notes.h"

namespace firn {

struct RunsOptions {
  std::vector<std::string>
      words;  ///< {}, {"list"}, {"find", WORD}, {"clean"}, {"pack", RUN…}, {"tag", RUN, TAG…}
  std::string runs = "runs";  ///< folder of the run folders
  std::optional<double> older_than_days;
  std::optional<int> keep;  ///< of the newest runs
  std::string outcome;
  std::string author;   ///< of a note or a tag; empty: the user
  bool remove = false;  ///< tag: takes the tags away
  bool yes = false;     ///< clean removes
  bool json = false;
};

/// Sets tags of a run, or takes them away; without a TAG shows them. @throws UsageError
int tag_run(const RunsOptions& options);
/// Adds a note to a run; without a text shows notes and tags with their authors. @throws UsageError
int note_run(const RunsOptions& options);
/// Seals the notes that runs got after their end. @throws UsageError
int seal_runs(const RunsOptions& options);

/// Returns notes as a list of {time_utc, author, host, text}.
nlohmann::ordered_json notes_json(const std::vector<runs::NoteEntry>& notes);

}  // namespace firn
