// The actions of firn runs: search, and notes and tags of runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runs/folder/notes.h"

namespace firn {

struct RunsOptions {
  std::vector<std::string>
      words;  ///< {}, {"list"}, {"find", WORD}, {"clean"}, {"pack", RUN…}, {"tag", RUN, TAG…}
  std::vector<std::string> runs = {"runs"};  ///< folders of run folders; find and list take several
  std::optional<double> older_than_days;
  std::optional<int> keep;  ///< of the newest runs
  std::string outcome;
  std::string sort = "started";  ///< find: key of the order, "-rms_um" from the largest
  int limit = 0;                 ///< find: the first so many; 0: all
  std::string author;            ///< of a note or a tag; empty: the user
  bool remove = false;           ///< tag: takes the tags away
  bool yes = false;              ///< clean removes
  bool json = false;
};

/// A run and the text of run_listing_text().
struct ListedRun {
  std::filesystem::path folder;
  std::string listing;
};

/// Shows the runs that meet the condition of the words behind "find". @throws UsageError naming the column
int find_runs(const RunsOptions& options);
/// Shows runs as text, or with their addresses as JSON. @param nothing is said if there is none
void show_runs(const std::vector<ListedRun>& runs, bool json, const char* nothing);

/// Returns "1.2 GB", "3.4 MB", "56 kB".
std::string runs_size_text(std::uint64_t bytes);

/// Returns the one folder of run folders. @throws UsageError: several were given
std::filesystem::path one_place(const RunsOptions& options);

/// Sets tags of a run, or takes them away; without a TAG shows them. @throws UsageError
int tag_run(const RunsOptions& options);
/// Adds a note to a run; without a text shows notes and tags with their authors. @throws UsageError
int note_run(const RunsOptions& options);
/// Seals the notes that runs got after their end. @throws UsageError
int seal_runs(const RunsOptions& options);

/// Copies sealed runs into the archive of the word behind "sync". @returns kFailed if a run was left out
int sync_runs(const RunsOptions& options);

/// Shows the use of prints by batch and instrument, and which limits of the lab file behind "use" are
/// near.
int sum_runs_use(const RunsOptions& options);

/// Returns notes as a list of {time_utc, author, host, text}.
nlohmann::ordered_json notes_json(const std::vector<runs::NoteEntry>& notes);

}  // namespace firn
