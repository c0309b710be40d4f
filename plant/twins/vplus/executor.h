// Executor executes the statements of V+, one at a time.
#pragma once

#include "plant/twins/vplus/evaluator.h"

namespace firn::plant::vplus {

class Executor : private Evaluator {
 public:
  explicit Executor(Controller& controller) : Evaluator(controller) {}
  /// Executes the statement at which `task` is. @throws Trouble, and the task is still there
  void step(Task& task);

 private:
  void call(Task& task, const Statement& s);
  void come_back(Task& task);
  void for_begin(Task& task, const Statement& s);
  void for_next(Task& task, const Statement& s);
  void branch(Task& task, const Statement& s);
  void device(Task& task, const Statement& s);
  void motion(Task& task, const Statement& s);
  void move(Task& task, const Statement& s);
};

}  // namespace firn::plant::vplus
