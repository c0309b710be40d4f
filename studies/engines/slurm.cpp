#include "studies/engines/slurm.h"

#include <climits>
#include <sstream>

#include "core/options/number.h"
#include "files/command.h"
#include "files/json.h"
#include "files/text_file.h"
#include "files/usage_error.h"

namespace firn {
namespace {

constexpr int kUsualArray = 1001;  // Slurm's default of MaxArraySize

// @throws UsageError with Slurm's words
std::string said_by(std::vector<std::string> words) {
  const std::string program = words.front();
  const CommandEnd end = run_command(std::move(words));
  if (end.missing())
    throw UsageError(program +
                     " is not installed here: a study goes to Slurm from a computer that has its commands");
  if (end.code != 0) throw UsageError(program + ": " + end.reason());
  return end.output;
}

}  // namespace

int Slurm::most_shards() const {
  std::istringstream lines(said_by({"scontrol", "show", "config"}));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("MaxArraySize"))
      if (const auto size = whole_number<int>(line.substr(line.find_last_of(" =") + 1), 2, INT_MAX))
        return *size - 1;
  return kUsualArray - 1;
}

std::string Slurm::submit(const ShardCommand& command, const std::string& partition) const {
  // Inside the script, so that a task that Slurm starts again has them too.
  const std::string script =
      "#!/bin/bash\n#SBATCH --requeue\n#SBATCH --open-mode=append\n"
      "# One shard of a study; firn compare wrote this.\nexec " +
      command.line("$SLURM_ARRAY_TASK_ID") + " --threads \"${SLURM_CPUS_PER_TASK:-1}\"\n";
  const std::filesystem::path job = write_engine_file(folder_, "job.sh", script);
  std::vector<std::string> words{"sbatch",
                                 "--parsable",
                                 "--job-name=firn-" + folder_.parent_path().filename().string(),
                                 "--array=" + ranges_text(command.wanted),
                                 "--output=" + (folder_ / "%a.log").string(),
                                 "--chdir=" + folder_.string()};
  if (!partition.empty()) words.push_back("--partition=" + partition);
  words.push_back(job.string());
  std::string number = said_by(words);
  number = number.substr(0, number.find_first_of(";\n"));
  const nlohmann::ordered_json record{{"job", number},
                                      {"shards", command.shards},
                                      {"tasks", command.wanted.size()},
                                      {"partition", partition}};
  write_engine_file(folder_, "job.json", record.dump(2) + "\n");
  return number;
}

std::optional<std::string> Slurm::job() const try {
  if (!std::filesystem::exists(folder_ / "job.json")) return std::nullopt;
  return nlohmann::json::parse(read_file(folder_ / "job.json")).at("job").get<std::string>();
} catch (const nlohmann::json::exception& error) {
  throw UsageError((folder_ / "job.json").string() + ": " + error.what());
}

std::map<std::string, int> Slurm::tasks() const {
  std::map<std::string, int> states;
  const auto number = job();
  if (!number) return states;
  const CommandEnd end = run_command({"squeue", "--noheader", "--array", "--format=%T", "--jobs=" + *number});
  if (end.code != 0 && end.errors.find("Invalid job id") == std::string::npos)
    throw UsageError("squeue: " + end.reason());
  std::istringstream lines(end.output);
  for (std::string state; lines >> state;) ++states[state];
  return states;
}

void Slurm::cancel() const {
  const auto number = job();
  if (!number) throw UsageError(folder_.string() + ": no job was submitted from here");
  said_by({"scancel", *number});
}

}  // namespace firn
