// Evaluator computes expressions of V+ and reads and sets its variables.
#pragma once

#include <string>

#include "plant/twins/vplus/controller.h"

namespace firn::plant::vplus {

/// All throw Trouble.
class Evaluator {
 protected:
  explicit Evaluator(Controller& controller) : c_(controller) {}

  Value value(Task& task, Expression e);
  float real(Task& task, Expression e);
  std::string text(Task& task, Expression e);
  std::int32_t integer(Task& task, Expression e);
  Reference reference(Task& task, Expression e);
  void store(Task& task, const Reference& r, Value value);
  void store(Task& task, Expression e, Value value) { store(task, reference(task, e), std::move(value)); }

  Controller& c_;

 private:
  float function(Task& task, const Node& n);
  std::string text_function(Task& task, const Node& n);
  std::string decode(Task& task, const Node& n);
  std::string encode(Task& task, const Node& n);
  Variable& variable(Task& task, const Reference& r);
  Value load(Task& task, Expression e);
  bool is_defined(Task& task, Expression e);
};

}  // namespace firn::plant::vplus
