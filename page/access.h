// Access tells whose request one is, and its rights, by the token that it shows: the one drawn at the
// start, an operator's without a name, or one of a table of people, which is read again when it has changed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "page/server.h"
#include "print/operator/people.h"

namespace firn::page {

struct Person {
  bool reads = false;
  bool commands = false;
  std::string name;  ///< empty: whoever has the token of the start, or nobody
};

/// Headers of a request that tell whose it is.
struct ShownRights {
  std::string authorization, cookies;
  std::string forwarded_user;  ///< X-Forwarded-User, which counts with a proxy's token alone
};

class Access {
 public:
  /// @param options token, is_public, people; without token and table whoever asks may read, and nobody
  /// commands. They outlive this. @throws UsageError as read_people()
  explicit Access(const ServerOptions& options);

  /// Returns whose request it is.
  Person of(const ShownRights& shown);
  /// Returns the same by the headers that no foreign page can make a browser send: not by cookies.
  Person by_header(const ShownRights& shown);
  /// Returns whose token it is.
  Person of_token(std::string_view token);
  /// Returns whether anybody may command.
  bool has_commands() const { return !options_.token.empty() || !options_.people.empty(); }

 private:
  Person nobody() const;
  const PersonRow* row_of(std::string_view token);
  void look();

  const ServerOptions& options_;
  std::filesystem::file_time_type changed_{};
  std::vector<PersonRow> people_;
};

}  // namespace firn::page
