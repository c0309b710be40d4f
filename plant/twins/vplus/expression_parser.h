// ExpressionParser reads expressions of V+ in its order of operators: NOT and COM; the minus before a value;
// *, /, MOD, AND, BAND; +, -, OR, BOR, XOR, BXOR; then comparisons [V+ Language User's Guide].
#pragma once

#include <map>
#include <string>
#include <vector>

#include "plant/twins/vplus/code.h"
#include "plant/twins/vplus/lexer.h"

namespace firn::plant::vplus {

class ExpressionParser {
 public:
  ExpressionParser(Code& code, const std::map<std::string, std::uint32_t>& locals)
      : code_(code), locals_(locals) {}

  void begin(std::vector<Token> tokens) {
    tokens_ = std::move(tokens);
    at_ = 0;
  }
  const Token& token() const { return tokens_[at_]; }
  const Token& ahead() const { return tokens_[at_ + 1 < tokens_.size() ? at_ + 1 : at_]; }
  void advance() { at_ += at_ + 1 < tokens_.size(); }
  bool take(std::string_view word);  ///< a sign or a name
  void require(std::string_view word);
  [[noreturn]] void refuse(const std::string& why) const;
  bool at_end() const { return token().kind == Token::Kind::kEnd; }

  Expression expression();
  Expression real();  ///< @throws std::invalid_argument for a string or a point
  Expression text();
  Expression variable();  ///< a name with its indices, if any
  Type type_of(Expression e) const { return code_.nodes[e].type; }
  Expression add(Node node);
  Expression constant(Value value);

 private:
  Expression binary(int level);
  Expression unary();
  Expression primary();
  Expression function(const std::string& name);
  std::vector<Expression> arguments(const std::string& name);
  Expression encode_argument();

  Code& code_;
  const std::map<std::string, std::uint32_t>& locals_;
  std::vector<Token> tokens_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

Type type_of_name(const std::string& name);

}  // namespace firn::plant::vplus
