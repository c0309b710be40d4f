#include "plant/twins/vplus/expression_parser.h"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>

namespace firn::plant::vplus {
namespace {

constexpr int kDeepest = 32;  ///< brackets within brackets: a bound of the parser's own stack
constexpr std::size_t kMostNodes = 1 << 20;

struct BinaryOperator {
  std::string_view word;
  Operator op;
  int level;  ///< 0 binds least
};
constexpr std::array<BinaryOperator, 19> kBinary{{
    {"==", Operator::kEqual, 0},        {"<>", Operator::kUnequal, 0},
    {"<=", Operator::kLessEqual, 0},    {"=<", Operator::kLessEqual, 0},
    {">=", Operator::kGreaterEqual, 0}, {"=>", Operator::kGreaterEqual, 0},
    {"<", Operator::kLess, 0},          {">", Operator::kGreater, 0},
    {"+", Operator::kPlus, 1},          {"-", Operator::kMinus, 1},
    {"OR", Operator::kOr, 1},           {"BOR", Operator::kBitOr, 1},
    {"XOR", Operator::kExclusiveOr, 1}, {"BXOR", Operator::kBitExclusiveOr, 1},
    {"*", Operator::kTimes, 2},         {"/", Operator::kOver, 2},
    {"MOD", Operator::kModulo, 2},      {"AND", Operator::kAnd, 2},
    {"BAND", Operator::kBitAnd, 2},
}};
constexpr int kLevels = 3;

struct FunctionEntry {
  std::string_view name;
  Function function;
  std::string_view
      arguments;  ///< r real, s string, p a variable of strings; after a bar they may be left out
  Type type;
};
constexpr std::array<FunctionEntry, 22> kFunctions{{
    {"ABS", Function::kAbs, "r", Type::kReal},       {"ASC", Function::kAsc, "s|r", Type::kReal},
    {"$CHR", Function::kChr, "r", Type::kString},    {"$DECODE", Function::kDecode, "psr", Type::kString},
    {"ERROR", Function::kError, "r|r", Type::kReal}, {"$ERROR", Function::kErrorText, "r", Type::kString},
    {"GETC", Function::kGetc, "r|r", Type::kReal},   {"INT", Function::kInt, "r", Type::kReal},
    {"$INTB", Function::kIntb, "r", Type::kString},  {"IOSTAT", Function::kIostat, "r", Type::kReal},
    {"LEN", Function::kLen, "s", Type::kReal},       {"MAX", Function::kMax, "rr", Type::kReal},
    {"$MID", Function::kMid, "srr", Type::kString},  {"MIN", Function::kMin, "rr", Type::kReal},
    {"POS", Function::kPos, "ss|r", Type::kReal},    {"#PPOINT", Function::kPpoint, "rrrr", Type::kPoint},
    {"SIGN", Function::kSign, "r", Type::kReal},     {"SPEED", Function::kSpeed, "r", Type::kReal},
    {"STATE", Function::kState, "r", Type::kReal},   {"TIMER", Function::kTimer, "r", Type::kReal},
    {"VAL", Function::kVal, "s", Type::kReal},       {"$ENCODE", Function::kEncode, "", Type::kString},
}};

}  // namespace

Type type_of_name(const std::string& name) {
  return name[0] == '$' ? Type::kString : name[0] == '#' ? Type::kPoint : Type::kReal;
}

void ExpressionParser::refuse(const std::string& why) const {
  throw std::invalid_argument(why + (at_end() ? " at the line's end" : " at '" + token().text + "'"));
}

bool ExpressionParser::take(std::string_view word) {
  if ((token().kind != Token::Kind::kSign && token().kind != Token::Kind::kName) || token().text != word)
    return false;
  advance();
  return true;
}

void ExpressionParser::require(std::string_view word) {
  if (!take(word)) refuse("'" + std::string(word) + "' is missing");
}

Expression ExpressionParser::add(Node node) {
  if (code_.nodes.size() >= kMostNodes) refuse("the program is too large");
  code_.nodes.push_back(std::move(node));
  return Expression(code_.nodes.size() - 1);
}

Expression ExpressionParser::constant(Value value) {
  Node n;
  n.type = value.type;
  n.constant = std::move(value);
  return add(std::move(n));
}

Expression ExpressionParser::expression() {
  if (++depth_ > kDeepest) refuse("brackets are too deep");
  const Expression e = binary(0);
  --depth_;
  return e;
}

Expression ExpressionParser::real() {
  const Expression e = expression();
  if (type_of(e) != Type::kReal) refuse("a number is missing");
  return e;
}

Expression ExpressionParser::text() {
  const Expression e = expression();
  if (type_of(e) != Type::kString) refuse("a string is missing");
  return e;
}

Expression ExpressionParser::binary(int level) {
  if (level == kLevels) return unary();
  Expression left = binary(level + 1);
  for (;;) {
    const auto* const found = std::find_if(kBinary.begin(), kBinary.end(), [&](const BinaryOperator& b) {
      return b.level == level && token().kind != Token::Kind::kText && token().text == b.word;
    });
    if (found == kBinary.end()) return left;
    advance();
    const Expression right = binary(level + 1);
    const Type type = type_of(left);
    const bool joins = type == Type::kString && (found->op == Operator::kPlus || level == 0);
    if (type_of(right) != type || (type != Type::kReal && !joins))
      refuse("types do not fit the operator before");
    Node n;
    n.op = found->op;
    n.type = level == 0 ? Type::kReal : type;
    n.children = {left, right};
    left = add(std::move(n));
  }
}

Expression ExpressionParser::unary() {
  Node n;
  n.op = take("-")     ? Operator::kNegative
         : take("NOT") ? Operator::kNot
         : take("COM") ? Operator::kComplement
                       : n.op;
  if (n.op == Operator::kConstant) return primary();
  if (++depth_ > kDeepest) refuse("signs are too many");
  const Expression of = unary();
  --depth_;
  if (type_of(of) != Type::kReal) refuse("a number is missing");
  n.children = {of};
  return add(std::move(n));
}

Expression ExpressionParser::primary() {
  const Token t = token();
  if (take("(")) {
    const Expression e = expression();
    require(")");
    code_.nodes[e].in_brackets = true;
    return e;
  }
  if (t.kind == Token::Kind::kNumber) {
    advance();
    return constant(Value::of(t.number));
  }
  if (t.kind == Token::Kind::kText) {
    advance();
    return constant(Value::of(t.text));
  }
  if (t.kind != Token::Kind::kName) refuse("a value is missing");
  if (t.text == "TRUE" || t.text == "FALSE") {
    advance();
    return constant(Value::of(t.text == "TRUE"));
  }
  if (t.text == "#PDEST") {
    advance();
    Node n;
    n.op = Operator::kFunction;
    n.function = Function::kPdest;
    n.type = Type::kPoint;
    return add(std::move(n));
  }
  if (ahead().kind == Token::Kind::kSign && ahead().text == "(") return function(t.text);
  return variable();
}

Expression ExpressionParser::variable() {
  const Token t = token();
  if (t.kind != Token::Kind::kName ||
      std::any_of(t.text.begin(), t.text.end(), [](char c) { return c >= 'A' && c <= 'Z'; }))
    refuse("a variable is missing");
  advance();
  Node n;
  n.op = Operator::kVariable;
  n.type = type_of_name(t.text);
  if (const auto local = locals_.find(t.text); local != locals_.end()) {
    n.local = true;
    n.variable = local->second;
  } else {
    const auto known = code_.global_of.emplace(t.text, std::uint32_t(code_.global_types.size()));
    if (known.second) code_.global_types.push_back(n.type);
    n.variable = known.first->second;
  }
  if (take("[")) {
    constexpr std::size_t kMostDimensions = 3;
    do n.children.push_back(real());
    while (take(","));
    require("]");
    if (n.children.size() > kMostDimensions || n.type == Type::kPoint) refuse("no such array");
  }
  return add(std::move(n));
}

std::vector<Expression> ExpressionParser::arguments(const std::string& name) {
  const auto* const entry = std::find_if(kFunctions.begin(), kFunctions.end(),
                                         [&](const FunctionEntry& f) { return f.name == name; });
  std::vector<Expression> given;
  bool optional = false;
  for (const char kind : entry->arguments) {
    if (kind == '|') {
      optional = true;
      continue;
    }
    if (optional && token().text == ")" && token().kind == Token::Kind::kSign) break;
    if (!given.empty()) require(",");
    given.push_back(kind == 'r' ? real() : kind == 's' ? text() : variable());
    if (kind == 'p' && type_of(given.back()) != Type::kString) refuse("a string is missing");
  }
  return given;
}

Expression ExpressionParser::encode_argument() {
  if (!take("/")) return expression();
  if (!take("I0")) refuse("this format is not known");
  Node n;
  n.op = Operator::kFormatInteger;
  return add(std::move(n));
}

Expression ExpressionParser::function(const std::string& name) {
  Node n;
  n.op = Operator::kFunction;
  if (name == "SWITCH") {
    advance();
    require("(");
    require("POWER");
    n.function = Function::kSwitchPower;
  } else if (name == "DEFINED") {
    advance();
    require("(");
    n.function = Function::kDefined;
    n.children = {variable()};
  } else {
    const auto* const entry = std::find_if(kFunctions.begin(), kFunctions.end(),
                                           [&](const FunctionEntry& f) { return f.name == name; });
    if (entry == kFunctions.end()) refuse("this function is not known");
    advance();
    require("(");
    n.function = entry->function;
    n.type = entry->type;
    if (n.function == Function::kEncode) do
        n.children.push_back(encode_argument());
      while (take(","));
    else
      n.children = arguments(name);
  }
  require(")");
  return add(std::move(n));
}

}  // namespace firn::plant::vplus
