#include "print/operator/people.h"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/options/enumerators.h"
#include "files/digest.h"
#include "files/text_file.h"
#include "files/trimmed.h"
#include "files/usage_error.h"
#include "print/operator/page_token.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> kRoleWords{"observer", "operator", "proxy"};
static_assert(kRoleWords.size() == kTableSize<Role>);
constexpr std::string_view kNoToken = "-";

std::string name_problem(std::string_view name) {
  if (name.empty()) return "a person has no name";
  if (name.size() > kMaxPersonBytes)
    return "a name has at most " + std::to_string(kMaxPersonBytes) + " bytes";
  for (const unsigned char c : name)
    if (c < 0x20 || c == 0x7f || c == ':') return "a name has no colon and no control character";
  if (name.front() == '#') return "a name does not begin with '#'";
  return "";
}

PersonRow parse_person(std::string_view line) {
  const std::size_t first = line.find(':'), second = line.find(':', first + 1);
  if (first == line.npos || second == line.npos)
    throw UsageError("must be NAME:ROLE:SHA256, or NAME:ROLE:- without a token");
  PersonRow row;
  row.name = line.substr(0, first);
  if (const std::string problem = name_problem(row.name); !problem.empty()) throw UsageError(problem);
  row.role = role_of(line.substr(first + 1, second - first - 1));
  const std::string_view digest = line.substr(second + 1);
  if (digest != kNoToken && !is_sha256_hex(digest))
    throw UsageError("the digest must be 64 hexadecimal digits, or -");
  if (digest != kNoToken) row.token_sha256 = digest;
  if (row.role == Role::kProxy && row.token_sha256.empty()) throw UsageError("a proxy needs a token");
  return row;
}

}  // namespace

std::string_view role_word(Role role) { return kRoleWords[std::size_t(role)]; }

Role role_of(std::string_view word) {
  const auto at = std::ranges::find(kRoleWords, word);
  if (at == kRoleWords.end())
    throw UsageError("'" + std::string(word.substr(0, 40)) + "': a role is observer, operator or proxy");
  return Role(at - kRoleWords.begin());
}

std::vector<PersonRow> read_people(const fs::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0)
    throw UsageError(file.string() + ": cannot be read: " + std::strerror(errno));
  if (found.st_mode & (S_IWGRP | S_IWOTH))
    throw UsageError(file.string() +
                     ": others than its owner may write it, and give themselves rights: chmod 600");
  const std::string text = read_file(file);
  std::vector<PersonRow> people;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line(trimmed(std::string_view(text).substr(at, end - at)));
    at = end + 1;
    ++number;
    if (line.empty() || line.front() == '#') continue;
    const auto refuse = [&](const std::string& why) {
      throw UsageError(file.string() + ":" + std::to_string(number) + ": " + why);
    };
    try {
      people.push_back(parse_person(line));
    } catch (const UsageError& e) {
      refuse(e.what());
    }
    const auto same = [&](const PersonRow& p) { return p.name == people.back().name; };
    if (std::ranges::count_if(people, same) > 1) refuse(people.back().name + " stands there twice");
    if (people.size() > kMaxPeople) refuse("more than " + std::to_string(kMaxPeople) + " people");
  }
  return people;
}

void write_people(const fs::path& file, const std::vector<PersonRow>& people) {
  std::string text = "# Who may watch or command prints: NAME:ROLE:SHA256 of the token (docs/page.md)\n";
  for (const PersonRow& p : people)
    text += p.name + ":" + std::string(role_word(p.role)) + ":" +
            (p.token_sha256.empty() ? std::string(kNoToken) : p.token_sha256) + "\n";
  if (file.has_parent_path()) fs::create_directories(file.parent_path());
  const fs::path part = file.string() + ".part";
  {
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    ::chmod(part.c_str(), S_IRUSR | S_IWUSR);
    if (!(out << text << std::flush)) {
      fs::remove(part);
      throw WriteError(file.string() + ": cannot be written");
    }
  }
  fs::rename(part, file);
}

std::string add_person(std::vector<PersonRow>& people, const std::string& name, Role role) {
  if (const std::string problem = name_problem(name); !problem.empty()) throw UsageError(problem);
  if (std::ranges::find(people, name, &PersonRow::name) != people.end())
    throw UsageError(name + ": is there already; remove the row for a new token");
  if (people.size() >= kMaxPeople) throw UsageError("at most " + std::to_string(kMaxPeople) + " people");
  const std::string token = new_page_token();
  people.push_back({name, role, token_digest(token)});
  return token;
}

std::string token_digest(std::string_view token) { return sha256_hex(std::as_bytes(std::span(token))); }

}  // namespace firn
