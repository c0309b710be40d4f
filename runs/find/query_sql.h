// Writes a Query as a condition of SQL on the tables of RunIndex.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "runs/find/query.h"

namespace firn::runs {

struct SqlCondition {
  std::string text;  ///< with a ? for each value
  std::vector<std::variant<double, std::string>> values;
};

/// @param text of the query, for errors
/// @throws QueryError: a key that no run can have, naming the nearest one
SqlCondition sql_of(const Query& query, std::string_view text);

/// @throws QueryError as above, at `column` of `text`
void check_query_key(const std::string& key, std::string_view text, std::size_t column);

}  // namespace firn::runs
