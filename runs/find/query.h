// Query holds a condition on runs, as firn runs find takes it: rms_um < 2 and meta.ink ~ "TPGDA".
//
//   condition  = term { "or" term }
//   term       = factor { "and" factor }
//   factor     = "not" factor | "(" condition ")" | key operator value | "has" key | text
//   operator   = "=" | "!=" | "<" | "<=" | ">" | ">=" | "~" | "!~"
//   key        = letter { letter | digit | "_" | "." }
//   value, text = word | number | "text in quotes", with \" and \\ for these two
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace firn::runs {

struct Query {
  enum class Kind : std::uint8_t { kAll, kAnd, kOr, kNot, kCompare, kHas, kMentions };
  enum class Operator : std::uint8_t {
    kEqual,
    kUnequal,
    kLess,
    kAtMost,
    kGreater,
    kAtLeast,
    kContains,
    kLacks
  };

  Kind kind = Kind::kAll;    ///< kAll: every run
  std::vector<Query> parts;  ///< of kAnd and kOr two or more, of kNot one
  std::string key;           ///< of kCompare and kHas
  Operator op = Operator::kEqual;
  std::string text;              ///< of kCompare and kMentions, as it was written
  std::optional<double> number;  ///< of kCompare: the text is a number, and has no quotes
  std::size_t column = 1;        ///< where it begins in the text, from 1
};

/// what() is "column 9: a value is wanted".
struct QueryError : std::runtime_error {
  QueryError(std::string_view text, std::size_t column, const std::string& problem);
  std::size_t column;
  std::string problem;
  std::string shown;  ///< two lines: the text, and a mark below the column
};

inline constexpr std::size_t kMaxQueryBytes = 4096, kMaxQueryDepth = 50;

/// Reads a condition; an empty text is kAll. @throws QueryError
Query parse_query(std::string_view text);

}  // namespace firn::runs
