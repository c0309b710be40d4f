#include "page/access.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <utility>

#include "page/client_frame.h"
#include "page/web_rules.h"

namespace firn::page {
namespace {

Person as_person(const PersonRow& row) { return {true, row.role == Role::kOperator, row.name}; }

}  // namespace

Access::Access(const ServerOptions& options) : options_(options) {
  if (options_.people.empty()) return;
  people_ = read_people(options_.people);
  changed_ = std::filesystem::last_write_time(options_.people);
}

// A table that cannot be read any more takes all rights: one that is being edited must not give old ones
// back.
void Access::look() {
  if (options_.people.empty()) return;
  std::error_code gone;
  const auto changed = std::filesystem::last_write_time(options_.people, gone);
  if (!gone && changed == changed_) return;
  changed_ = gone ? std::filesystem::file_time_type{} : changed;
  people_.clear();
  try {
    people_ = read_people(options_.people);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "page: %s: nobody of the table may do anything\n", e.what());
  }
}

Person Access::nobody() const {
  return {options_.is_public || (options_.token.empty() && options_.people.empty()), false, ""};
}

const PersonRow* Access::row_of(std::string_view token) {
  if (token.empty()) return nullptr;
  look();
  const std::string digest = token_digest(token);
  const PersonRow* found = nullptr;  // every row is compared: the time tells nothing
  for (const PersonRow& p : people_)
    if (!p.token_sha256.empty() && same_secret(p.token_sha256, digest)) found = &p;
  return found;
}

Person Access::of_token(std::string_view token) {
  if (!options_.token.empty() && same_secret(token, options_.token)) return {true, true, ""};
  const PersonRow* row = row_of(token);
  return row && row->role != Role::kProxy ? as_person(*row) : nobody();
}

Person Access::by_header(const ShownRights& shown) {
  const std::string_view token = bearer_token(shown.authorization);
  const PersonRow* row = row_of(token);
  if (!row || row->role != Role::kProxy) return of_token(token);
  const auto named = std::ranges::find(people_, shown.forwarded_user, &PersonRow::name);
  return named != people_.end() && named->role != Role::kProxy ? as_person(*named) : nobody();
}

Person Access::of(const ShownRights& shown) {
  Person best = by_header(shown);
  for (const std::string_view token : cookie_tokens(shown.cookies)) {
    if (best.reads && (best.commands || !best.name.empty())) break;
    if (const Person p = of_token(token); p.commands || !p.name.empty()) best = p;
  }
  return best;
}

}  // namespace firn::page
