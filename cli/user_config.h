// UserConfig holds a user's wishes that hold for every command: the folder of his runs, and his name.
#pragma once

#include <filesystem>
#include <string>

namespace firn {

struct UserConfig {
  std::filesystem::path file;  ///< where it is looked for; "": neither XDG_CONFIG_HOME nor HOME is set
  std::string runs;            ///< full path; "": the file names none
  std::string name;            ///< of the user; "": the file names none
  std::string notify;          ///< command that is told of a print's end (cli/notify.h); "": none
};

/// Reads $XDG_CONFIG_HOME/firn/config.toml, without that variable ~/.config/firn/config.toml
/// [XDG Base Directory Specification]. A missing file names nothing.
/// @throws ConfigError with file, line and key
UserConfig read_user_config();

/// The folder of run folders for a command that is given none, and who names it.
struct RunsFolder {
  std::string folder;    ///< $FIRN_RUNS, else that of the user's configuration, else "runs"
  std::string named_by;  ///< "FIRN_RUNS", the file, or "built in"
};
/// @throws ConfigError as read_user_config()
RunsFolder default_runs_folder();

}  // namespace firn
