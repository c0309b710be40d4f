// UserConfig holds a user's wishes that hold for every command: the folder of his runs, and his name.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace firn {

struct UserConfig {
  std::filesystem::path file;    ///< where it is looked for; "": neither XDG_CONFIG_HOME nor HOME is set
  std::string runs;              ///< full path; "": the file names none
  std::string name;              ///< of the user; "": the file names none
  std::string notify;            ///< command that is told of a print's end (cli/notify.h); "": none
  std::filesystem::path people;  ///< table of those who may watch or command (print/operator/people.h),
                                 ///< beside `file`, also if there is none yet; "": as of `file`
};

/// Reads $XDG_CONFIG_HOME/firn/config.toml, without that variable ~/.config/firn/config.toml
/// [XDG Base Directory Specification]. A missing file names nothing.
/// @throws ConfigError with file, line and key
UserConfig read_user_config();

/// Returns the table of people if there is one. @throws ConfigError as read_user_config()
std::filesystem::path people_table();

/// Returns "Ada Lovelace (firn ctl)" of a user who has told his name, else "firn ctl": the sender of an
/// order, for the record; "firn ctl" too where the configuration cannot be read.
std::string sender_name(const std::string& program);

/// Adds "meta.operator=NAME" for a print that names no operator, if the user has told his name.
/// @param overrides of the experiment in `file` @throws ConfigError also of the experiment
void name_operator(const std::filesystem::path& file, std::vector<std::string>& overrides);

/// The folder of run folders for a command that is given none, and who names it.
struct RunsFolder {
  std::string folder;    ///< $FIRN_RUNS, else that of the user's configuration, else "runs"
  std::string named_by;  ///< "FIRN_RUNS", the file, or "built in"
};
/// @throws ConfigError as read_user_config()
RunsFolder default_runs_folder();

}  // namespace firn
