#include "cli/user_config.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>

#include "config/error.h"
#include "config/field_rows.h"
#include "config/include.h"
#include "config/reader.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

// The specification wants full paths and says that others are passed over.
fs::path config_file() {
  const fs::path given = variable("XDG_CONFIG_HOME"), home = variable("HOME");
  if (given.is_absolute()) return given / "firn" / "config.toml";
  return home.is_absolute() ? home / ".config" / "firn" / "config.toml" : fs::path();
}

std::vector<Field> user_fields(UserConfig& user) {
  return {
      {"user.runs", &user.runs, "", field_rows::text(),
       "folder of run folders: a full path, or one below ~/"},
      {"user.name", &user.name, "", field_rows::text(),
       "who you are: operator of your prints, author of your notes, sender of your orders"},
      {"notify.command", &user.notify, "", field_rows::text(), "is started when a print ends"},
  };
}

}  // namespace

UserConfig read_user_config() {
  UserConfig user;
  user.file = config_file();
  if (!user.file.empty()) user.people = user.file.parent_path() / "people";
  std::error_code none;
  if (user.file.empty() || !fs::exists(user.file, none)) return user;
  const Origins origins = read_fields(user_fields(user), read_config_text(user.file, ""), user.file.string());
  if (user.runs.empty()) return user;
  if (user.runs.starts_with("~/")) user.runs = variable("HOME") + user.runs.substr(1);
  // A path from the current folder would mean another one for each command.
  if (!fs::path(user.runs).is_absolute())
    throw ConfigError(user.file.string(), origins.at("user.runs").line, "user.runs",
                      "user.runs = \"" + user.runs + "\": must be a full path, or one below ~/");
  return user;
}

fs::path people_table() {
  const fs::path file = read_user_config().people;
  std::error_code none;
  return !file.empty() && fs::exists(file, none) ? file : fs::path();
}

// No mistake in a file keeps an order from its print: it may be a stop.
std::string sender_name(const std::string& program) try {
  const UserConfig user = read_user_config();
  return user.name.empty() ? program : user.name + " (" + program + ")";
} catch (const ConfigError&) {
  return program;
}

void name_operator(const fs::path& file, std::vector<std::string>& overrides) {
  const UserConfig user = read_user_config();
  if (user.name.empty()) return;
  const Meta given = load_meta(file, overrides).values;
  if (std::ranges::find(given, "operator", &MetaEntry::key) == given.end())
    overrides.push_back("meta.operator=" + user.name);
}

RunsFolder default_runs_folder() {
  if (const std::string given = variable("FIRN_RUNS"); !given.empty()) return {given, "FIRN_RUNS"};
  const UserConfig user = read_user_config();
  if (!user.runs.empty()) return {user.runs, user.file.string()};
  return {"runs", "built in"};
}

}  // namespace firn
