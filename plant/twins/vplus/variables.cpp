// Variables of V+: scalars, elements, and parameters that stand for a variable of the caller.

#include <cmath>

#include "plant/twins/vplus/evaluator.h"

namespace firn::plant::vplus {
namespace {

constexpr int kUndefinedValue = -406;  // *Undefined value*
constexpr int kInvalidIndex = -404;    // an array's index beyond 0 to 32767; the number is not checked
constexpr int kOutOfMemory = -451;     // the number is not checked
constexpr float kMaxIndex = 32767.0F;
constexpr std::int64_t kMostElements = 1 << 19;  // 8192 points of four numbers in two slots are 65,536

}  // namespace

// A parameter that stands for another variable is followed to that variable at the call already.
Reference Evaluator::reference(Task& task, Expression e) {
  const Node& n = c_.code.nodes[e];
  Reference r{!n.local, std::uint32_t(task.frames.size() - 1), n.variable, kScalar};
  if (n.local && task.frames.back().locals[n.variable].is_reference)
    r = task.frames.back().locals[n.variable].to;
  if (n.children.empty()) return r;
  if (r.element != kScalar) throw Trouble{kInvalidIndex, "an element has no elements"};
  r.element = 0;
  for (const Expression index : n.children) {
    const float value = real(task, index);
    if (!(value >= 0.0F && value <= kMaxIndex) || value != std::trunc(value))
      throw Trouble{kInvalidIndex, "invalid array index"};
    r.element = r.element << 16 | Element(value);
  }
  return r;
}

Variable& Evaluator::variable(Task& task, const Reference& r) {
  if (r.global) return c_.globals[r.variable];
  return task.frames[r.frame].locals[r.variable].own;
}

bool Evaluator::is_defined(Task& task, Expression e) {
  const Reference r = reference(task, e);
  const Variable& v = variable(task, r);
  if (r.element == kScalar) return v.scalar.defined;
  return c_.code.nodes[e].type == Type::kString ? v.texts.contains(r.element) : v.reals.contains(r.element);
}

Value Evaluator::load(Task& task, Expression e) {
  const Reference r = reference(task, e);
  const Variable& v = variable(task, r);
  if (r.element == kScalar) {
    if (v.scalar.defined) return v.scalar;
  } else if (c_.code.nodes[e].type == Type::kString) {
    if (const auto found = v.texts.find(r.element); found != v.texts.end()) return Value::of(found->second);
  } else if (const auto found = v.reals.find(r.element); found != v.reals.end()) {
    return Value::of(found->second);
  }
  throw Trouble{kUndefinedValue, "undefined value"};
}

void Evaluator::store(Task& task, const Reference& r, Value value) {
  Variable& v = variable(task, r);
  if (r.element == kScalar) {
    v.scalar = std::move(value);
    return;
  }
  const bool is_new = value.type == Type::kString
                          ? v.texts.insert_or_assign(r.element, std::move(value.text)).second
                          : v.reals.insert_or_assign(r.element, value.real).second;
  if (is_new && ++c_.elements > kMostElements) throw Trouble{kOutOfMemory, "out of memory"};
}

}  // namespace firn::plant::vplus
