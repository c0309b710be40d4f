// StudyOptions are the options of every command whose work is a study: shards, other computers, state.
#pragma once

#include <string>

namespace firn {

class OptionSet;

struct StudyOptions {
  std::string output;             ///< study folder
  int threads = 0;                ///< 0 = as many as the machine has
  std::string shard;              ///< "K/N": makes this share alone, into its own journal
  int most = 0;                   ///< > 0: so many now, the rest later
  bool again = false;             ///< those that stopped before their end are made again
  bool dry_run = false;           ///< tells the work to do, and makes nothing
  bool status = false;            ///< tells the results on record
  std::string platform = "this";  ///< "any": results of other platforms count too
  std::string on;                 ///< "slurm[:PARTITION]" or "ssh:HOST,HOST"; empty: this computer
  double chunk_s = 60.0;          ///< processor time of a shard that `on` makes
  bool detach = false;            ///< `on`: returns when the shards are submitted
  bool cancel = false;            ///< `on`: ends the shards that were submitted
  bool json = false;

  /// Returns the first option that has a meaning only with a folder of results, as it is written; "" = none.
  std::string needs_folder() const;
  bool any_platform() const { return platform == "any"; }
};

/// Declares all but `output` and `json`. @param of the things made: "prints"
void declare_study(OptionSet& options, StudyOptions& o, const std::string& of);

}  // namespace firn
