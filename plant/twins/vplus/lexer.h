// Lexer splits a line of V+ into tokens.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace firn::plant::vplus {

struct Token {
  enum class Kind : unsigned char { kNumber, kText, kName, kSign, kEnd };
  Kind kind = Kind::kEnd;
  std::string text;  ///< names as written: V+ keeps its words in capitals and variables in small letters
  float number = 0.0F;
};

/// Returns the tokens of a line without its comment, with a kEnd behind them.
/// @throws std::invalid_argument for a string that does not end, a number that is none, or another character
std::vector<Token> tokens_of(std::string_view line);

}  // namespace firn::plant::vplus
