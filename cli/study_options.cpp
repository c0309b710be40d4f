#include "cli/study_options.h"

#include "cli/option_set.h"

namespace firn {

std::string StudyOptions::needs_folder() const {
  if (!shard.empty()) return "--shard";
  if (most > 0) return "--max";
  if (again) return "--again";
  if (dry_run) return "--dry-run";
  if (status) return "--status";
  if (!on.empty()) return "--on";
  if (detach) return "--detach";
  return cancel ? "--cancel" : "";
}

void declare_study(OptionSet& options, StudyOptions& o, const std::string& of) {
  options.option("--shard", o.shard,
                 "K/N: makes this share of the " + of + " alone, into shards/K-of-N.journal");
  options.option("--max", o.most, of + " now; the same command goes on with the rest").within(1, 100000000);
  options.flag("--again", o.again, "makes the " + of + " again that stopped before their end, and no others");
  options.flag("--dry-run", o.dry_run,
               "tells " + of + ", hours, bytes and shards of a minute, and makes nothing");
  options.flag("--status", o.status, "tells the results on record, of each kind and in each shard");
  options
      .option("--platform", o.platform,
              "any: results of platforms whose functions give other results count too")
      .one_of({"this", "any"});
  options.option("--on", o.on,
                 "slurm[:PARTITION] or ssh:HOST,HOST: where the " + of + " are made, in shards");
  options.option("--chunk", o.chunk_s, "--on: processor time of a shard [s]").within(0.01, 1e6);
  options.flag("--detach", o.detach, "--on slurm: returns when the shards are submitted");
  options.flag("--cancel", o.cancel, "--on slurm: ends the shards that were submitted");
  options.thread_option(o.threads);
}

}  // namespace firn
