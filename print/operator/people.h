// People are those who may watch or command prints through the page, each with a token of his own: a table of
// names, roles and digests of tokens.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

enum class Role : std::uint8_t {
  kObserver,  ///< reads
  kOperator,  ///< reads and commands
  kProxy,     ///< a proxy, which says by a header of whom each request is
};
/// Returns "observer", "operator" or "proxy".
std::string_view role_word(Role role);
/// @throws UsageError naming the word and the known ones
Role role_of(std::string_view word);

struct PersonRow {
  std::string name;
  Role role = Role::kObserver;
  std::string token_sha256;  ///< 64 hexadecimal digits; empty: known through a proxy alone
};

inline constexpr std::size_t kMaxPeople = 1000, kMaxPersonBytes = 60;

/// Reads a table: a line "NAME:ROLE:SHA256" for each, or "NAME:ROLE:-"; "#" begins a comment.
/// @throws UsageError naming file, line and requirement: also of a file that others than its owner may write
std::vector<PersonRow> read_people(const std::filesystem::path& file);
/// Writes the table for its owner alone; the earlier one stays until the new one is whole. @throws WriteError
void write_people(const std::filesystem::path& file, const std::vector<PersonRow>& people);

/// Adds a person. @returns the token, which the table cannot give again
/// @throws UsageError: the name is there already, or is none
std::string add_person(std::vector<PersonRow>& people, const std::string& name, Role role);
/// Returns the digest by which the table knows a token.
std::string token_digest(std::string_view token);

}  // namespace firn
