// run_people keeps the table of those who may watch or command prints through the page.
#include "cli/commands.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/option_set.h"
#include "cli/user_config.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/operator/people.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

enum class PeopleAction { kList, kAdd, kRemove };

struct PeopleOptions {
  PeopleAction action = PeopleAction::kList;
  std::string file;  ///< empty: that of the user's configuration
  std::string name;
  std::string role = "observer";
  bool through_proxy = false;  ///< no token of his own
  bool json = false;
};

fs::path table_of(const PeopleOptions& o) {
  const fs::path file = o.file.empty() ? read_user_config().people : fs::path(o.file);
  if (file.empty())
    throw UsageError("people: --file names no table, and there is no folder for your configuration");
  return file;
}

int list_people(const PeopleOptions& o) {
  const fs::path file = table_of(o);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  const auto people = fs::exists(file) ? read_people(file) : std::vector<PersonRow>();
  for (const PersonRow& p : people) {
    all.push_back({{"name", p.name}, {"role", role_word(p.role)}, {"token", !p.token_sha256.empty()}});
    if (!o.json)
      fmt::print("{:<9} {}{}\n", role_word(p.role), p.name,
                 p.token_sha256.empty() ? " (through a proxy)" : "");
  }
  if (o.json) fmt::print("{}\n", nlohmann::ordered_json{{"file", file.string()}, {"people", all}}.dump(2));
  if (!o.json && people.empty()) fmt::print("{}: nobody\n", file.string());
  return kOk;
}

int add_to_people(const PeopleOptions& o) {
  const fs::path file = table_of(o);
  auto people = fs::exists(file) ? read_people(file) : std::vector<PersonRow>();
  const Role role = role_of(o.role);
  if (o.through_proxy && role == Role::kProxy) throw UsageError("people: the proxy itself needs a token");
  std::string token = add_person(people, o.name, role);
  if (o.through_proxy) {
    people.back().token_sha256.clear();
    token.clear();
  }
  write_people(file, people);
  if (o.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"file", file.string()},
                                              {"name", o.name},
                                              {"role", o.role},
                                              {"token", token.empty() ? nlohmann::ordered_json(nullptr)
                                                                      : nlohmann::ordered_json(token)}}
                           .dump(2));
  else if (token.empty())
    fmt::print("{}: {} {}, known through a proxy\n", file.string(), o.role, o.name);
  else
    fmt::print("{}\nthe token of {}, {}; the table keeps its digest alone, so it is shown this once\n", token,
               o.name, o.role);
  return kOk;
}

int remove_from_people(const PeopleOptions& o) {
  const fs::path file = table_of(o);
  auto people = fs::exists(file) ? read_people(file) : std::vector<PersonRow>();
  if (std::erase_if(people, [&](const PersonRow& p) { return p.name == o.name; }) == 0)
    throw UsageError(file.string() + ": has no " + o.name);
  write_people(file, people);
  return o.json ? list_people(o) : kOk;
}

/// @throws UsageError: a table that cannot be read, a name that is there or is not
int run_people(const PeopleOptions& o) {
  switch (o.action) {
    case PeopleAction::kList:
      return list_people(o);
    case PeopleAction::kAdd:
      return add_to_people(o);
    case PeopleAction::kRemove:
      return remove_from_people(o);
  }
  return kUsage;
}

}  // namespace

void declare_people(OptionSet& options) {
  const auto with = [&](const char* name, const char* summary, PeopleAction action) {
    OptionSet sub = options.subcommand(name, summary);
    auto& o = sub.calls(run_people);
    o.action = action;
    if (action != PeopleAction::kList) sub.option("NAME", o.name, "as records name the person").required();
    if (action == PeopleAction::kAdd) {
      sub.option("--role", o.role,
                 "observer, operator, or proxy, which says by a header of whom a request is")
          .show_default();
      sub.flag("--through-proxy", o.through_proxy, "no token of his own: a proxy names him");
    }
    sub.option("--file", o.file, "table; default: people of your configuration's folder");
    sub.json_flag(o.json);
  };
  with("list", "names and roles", PeopleAction::kList);
  with("add", "adds a person and shows his token, once", PeopleAction::kAdd);
  with("remove", "takes a person's rights away", PeopleAction::kRemove);
  options.require_subcommand();
}

}  // namespace firn
