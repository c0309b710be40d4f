// Expressions of V+. Every operation rounds to a real of 32 bits: the least that the controller can hold.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/options/number.h"
#include "plant/twins/vplus/evaluator.h"

namespace firn::plant::vplus {
namespace {

constexpr int kDivideByZero = -409;  // the numbers of these three are not checked
constexpr int kStringTooLong = -417;
constexpr int kIllegalValue = -402;
constexpr float kMost24Bits = 16777215.0F;  // integers that a real holds one by one

bool truth(float value) { return value != 0.0F; }

/// The number that a text begins with, 0 for none.
float number_before(std::string_view text) {
  while (!text.empty() && text[0] == ' ') text.remove_prefix(1);
  return take_number<float>(text).value_or(0.0F);
}

std::size_t place(float value) { return std::size_t(std::clamp(value, 1.0F, 1000.0F)) - 1; }

}  // namespace

Value Evaluator::value(Task& task, Expression e) {
  const Node& n = c_.code.nodes[e];
  if (n.op == Operator::kConstant) return n.constant;
  if (n.op == Operator::kVariable) return load(task, e);
  if (n.type == Type::kReal) return Value::of(real(task, e));
  if (n.type == Type::kString) return Value::of(text(task, e));
  if (n.function == Function::kPdest) return Value::of(c_.robot.destination());
  PrecisionPoint p{};
  for (std::size_t k = 0; k < p.size(); ++k) p[k] = real(task, n.children[k]);
  return Value::of(p);
}

std::int32_t Evaluator::integer(Task& task, Expression e) {
  const float value = std::trunc(real(task, e));
  if (!(std::abs(value) <= kMost24Bits)) throw Trouble{kIllegalValue, "illegal value"};
  return std::int32_t(value);
}

float Evaluator::real(Task& task, Expression e) {
  const Node& n = c_.code.nodes[e];
  const auto left = [&] { return real(task, n.children[0]); };
  const auto right = [&] { return real(task, n.children[1]); };
  const auto order = [&]() -> int {
    if (c_.code.nodes[n.children[0]].type == Type::kString) {
      const std::string a = text(task, n.children[0]), b = text(task, n.children[1]);
      return a < b ? -1 : a > b;
    }
    const float a = left(), b = right();
    return a < b ? -1 : a > b;
  };
  const auto as_value = [](bool yes) { return yes ? -1.0F : 0.0F; };
  switch (n.op) {
    case Operator::kConstant:
      return n.constant.real;
    case Operator::kVariable:
      return load(task, e).real;
    case Operator::kFunction:
      return function(task, n);
    case Operator::kNegative:
      return -left();
    case Operator::kNot:
      return as_value(!truth(left()));
    case Operator::kComplement:
      return float(~integer(task, n.children[0]));
    case Operator::kTimes: {
      const float a = left();
      return a * right();
    }
    case Operator::kOver: {
      const float a = left(), b = right();
      if (b == 0.0F) throw Trouble{kDivideByZero, "divide by zero"};
      return a / b;
    }
    case Operator::kModulo: {
      const std::int32_t a = integer(task, n.children[0]), b = integer(task, n.children[1]);
      if (b == 0) throw Trouble{kDivideByZero, "divide by zero"};
      return float(a % b);
    }
    // Both sides are read, as V+ does.
    case Operator::kAnd: {
      const bool a = truth(left()), b = truth(right());
      return as_value(a && b);
    }
    case Operator::kOr: {
      const bool a = truth(left()), b = truth(right());
      return as_value(a || b);
    }
    case Operator::kExclusiveOr: {
      const bool a = truth(left()), b = truth(right());
      return as_value(a != b);
    }
    case Operator::kBitAnd: {
      const std::int32_t a = integer(task, n.children[0]);
      return float(a & integer(task, n.children[1]));
    }
    case Operator::kBitOr: {
      const std::int32_t a = integer(task, n.children[0]);
      return float(a | integer(task, n.children[1]));
    }
    case Operator::kBitExclusiveOr: {
      const std::int32_t a = integer(task, n.children[0]);
      return float(a ^ integer(task, n.children[1]));
    }
    case Operator::kPlus: {
      const float a = left();
      return a + right();
    }
    case Operator::kMinus: {
      const float a = left();
      return a - right();
    }
    case Operator::kLess:
      return as_value(order() < 0);
    case Operator::kLessEqual:
      return as_value(order() <= 0);
    case Operator::kEqual:
      return as_value(order() == 0);
    case Operator::kUnequal:
      return as_value(order() != 0);
    case Operator::kGreaterEqual:
      return as_value(order() >= 0);
    case Operator::kGreater:
      return as_value(order() > 0);
    case Operator::kFormatInteger:
      break;
  }
  throw Trouble{kIllegalValue, "illegal value"};
}

std::string Evaluator::text(Task& task, Expression e) {
  const Node& n = c_.code.nodes[e];
  if (n.op == Operator::kConstant) return n.constant.text;
  if (n.op == Operator::kVariable) return load(task, e).text;
  if (n.op == Operator::kFunction) return text_function(task, n);
  std::string joined = text(task, n.children[0]);
  joined += text(task, n.children[1]);
  if (joined.size() > kMaxString) throw Trouble{kStringTooLong, "string too long"};
  return joined;
}

float Evaluator::function(Task& task, const Node& n) {
  const auto r = [&](std::size_t k) { return real(task, n.children[k]); };
  const auto given = [&](std::size_t k) { return n.children.size() > k; };
  switch (n.function) {
    case Function::kAbs:
      return std::abs(r(0));
    case Function::kAsc: {
      const std::string s = text(task, n.children[0]);
      const std::size_t at = given(1) ? place(r(1)) : 0;
      return at < s.size() ? float(static_cast<unsigned char>(s[at])) : -1.0F;
    }
    case Function::kDefined:
      return is_defined(task, n.children[0]) ? -1.0F : 0.0F;
    case Function::kError: {
      const std::int32_t of = integer(task, n.children[0]);
      return of >= 0 && of < std::int32_t(kTasks) ? float(c_.tasks[std::size_t(of)].error)
                                                  : float(task.error);
    }
    case Function::kGetc:
      return float(c_.iostat = c_.network.read_byte());
    case Function::kInt:
      return std::trunc(r(0));
    case Function::kIostat:
      return float(c_.iostat);
    case Function::kLen:
      return float(text(task, n.children[0]).size());
    case Function::kMax: {
      const float a = r(0);
      return std::max(a, r(1));
    }
    case Function::kMin: {
      const float a = r(0);
      return std::min(a, r(1));
    }
    case Function::kPos: {
      const std::string s = text(task, n.children[0]), part = text(task, n.children[1]);
      const std::size_t at = s.find(part, given(2) ? place(r(2)) : 0);
      return at == std::string::npos ? 0.0F : float(at + 1);
    }
    case Function::kSign:
      return r(0) < 0.0F ? -1.0F : 1.0F;
    case Function::kSpeed:
      return integer(task, n.children[0]) == 1 ? float(c_.monitor_percent) : task.percent;
    case Function::kState:
      return float(c_.robot.state(integer(task, n.children[0])));
    case Function::kSwitchPower:
      return c_.robot.powered() ? -1.0F : 0.0F;
    case Function::kTimer: {
      const std::int32_t of = integer(task, n.children[0]);
      if (of < 0 || std::size_t(of) >= c_.timers_us.size()) throw Trouble{kIllegalValue, "illegal value"};
      return float(double(c_.now_us - c_.timers_us[std::size_t(of)]) * 1e-6 / c_.clock());
    }
    case Function::kVal:
      return number_before(text(task, n.children[0]));
    default:
      throw Trouble{kIllegalValue, "illegal value"};
  }
}

std::string Evaluator::text_function(Task& task, const Node& n) {
  switch (n.function) {
    case Function::kChr:
      return std::string(1, char(std::uint8_t(integer(task, n.children[0]) & 255)));
    case Function::kDecode:
      return decode(task, n);
    case Function::kEncode:
      return encode(task, n);
    case Function::kErrorText:
      return "*Error " + std::to_string(integer(task, n.children[0])) + "*";
    case Function::kIntb: {
      const std::int32_t value = integer(task, n.children[0]);
      return {char(std::uint8_t(value >> 8 & 255)), char(std::uint8_t(value & 255))};
    }
    case Function::kMid: {
      const std::string s = text(task, n.children[0]);
      const std::size_t at = place(real(task, n.children[1]));
      const float length = real(task, n.children[2]);
      return at >= s.size() || length <= 0.0F ? std::string() : s.substr(at, place(length) + 1);
    }
    default:
      throw Trouble{kIllegalValue, "illegal value"};
  }
}

// Mode 0: the characters before the first separator; mode 1: the separators at the begin. Either leaves the
// variable.
std::string Evaluator::decode(Task& task, const Node& n) {
  const std::string separators = text(task, n.children[1]);
  const bool takes_separators = real(task, n.children[2]) > 0.0F;
  std::string from = text(task, n.children[0]);
  std::size_t end = takes_separators ? from.find_first_not_of(separators) : from.find_first_of(separators);
  end = std::min(end, from.size());
  std::string taken = from.substr(0, end);
  store(task, n.children[0], Value::of(from.substr(end)));
  return taken;
}

std::string Evaluator::encode(Task& task, const Node& n) {
  std::string out;
  bool integers = false;
  for (const Expression e : n.children) {
    const Node& part = c_.code.nodes[e];
    if (part.op == Operator::kFormatInteger) {
      integers = true;
    } else if (part.type == Type::kString) {
      out += text(task, e);
    } else {
      const float value = std::round(real(task, e));
      if (!integers || !(std::abs(value) <= 2.0e9F)) throw Trouble{kIllegalValue, "illegal value"};
      out += std::to_string(std::int64_t(value));
    }
  }
  if (out.size() > kMaxString) throw Trouble{kStringTooLong, "string too long"};
  return out;
}

}  // namespace firn::plant::vplus
