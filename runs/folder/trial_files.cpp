#include "runs/folder/trial_files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <vector>

#include "files/run_paths.h"
#include "files/usage_error.h"

namespace firn::runs {
namespace {

namespace fs = std::filesystem;

void remove_in(const fs::path& folder, bool (*wanted)(const std::string& name)) {
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(folder, error))) return;
  std::vector<fs::path> trials;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const std::string name = entry.path().filename().string(); is_trial_file(name) && wanted(name))
      trials.push_back(entry.path());
  for (const fs::path& trial : trials) {
    struct stat s {};
    if (::lstat(trial.c_str(), &s) == 0 && S_ISREG(s.st_mode) && s.st_uid == ::geteuid())
      fs::remove(trial, error);
  }
}

}  // namespace

bool is_trial_file(const std::string& path) {
  for (const char* ending : {".part", ".packed", ".repairing", ".repairing.idx", ".new"})
    if (path.ends_with(ending)) return true;
  return false;
}

void remove_trial_files(const fs::path& run) {
  const RunPaths paths(run);
  for (const fs::path& folder : {paths.nodes_path(), paths.world_path(), paths.inputs_path()})
    remove_in(folder, [](const std::string&) { return true; });
  remove_in(run, [](const std::string& name) {
    return name.starts_with(RunPaths::kLog) || name.starts_with(RunPaths::kWorldRecord) ||
           name.starts_with(RunPaths::kResult);
  });
}

void refuse_links(const fs::path& run) {
  for (auto it = fs::recursive_directory_iterator(run); it != fs::recursive_directory_iterator(); ++it) {
    const fs::file_type type = it->symlink_status().type();
    const std::string path = it->path().lexically_relative(run).generic_string();
    if (path == RunPaths::kPorts) {
      it.disable_recursion_pending();
      continue;
    }
    if (type != fs::file_type::regular && type != fs::file_type::directory &&
        type != fs::file_type::socket)  // of the operator's desk
      throw UsageError(it->path().string() + ": is " +
                       (type == fs::file_type::symlink ? "a link" : "no regular file") +
                       "; nothing is written into a run folder that has one");
  }
}

}  // namespace firn::runs
