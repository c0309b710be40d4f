// InterpreterHold takes the interpreter's lock for a scope, with one thread state for the thread's whole
// life.
#pragma once

#include <pybind11/pybind11.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace firn::python {

/// Keeps this thread's state of the interpreter until the thread ends. pybind11's own hold makes a state
/// for each scope of a thread and clears it at the end with a count of zero: an object that takes the
/// interpreter while it is cleared then frees the state, which is freed again.
class ThreadState {
 public:
  ThreadState() : found_(PyGILState_GetThisThreadState() != nullptr) {
    if (found_) return;  // that of the thread which started the interpreter
    PyGILState_Ensure();
    state_ = PyEval_SaveThread();
  }
  ~ThreadState() {
    if (found_ || getpid() == syscall(SYS_gettid)) return;  // the process ends: nobody may hold its end up
    PyEval_RestoreThread(state_);
    PyThreadState_Clear(state_);  // with the count of the constructor
    PyThreadState_DeleteCurrent();
  }
  ThreadState(const ThreadState&) = delete;
  ThreadState& operator=(const ThreadState&) = delete;

 private:
  bool found_;
  PyThreadState* state_ = nullptr;
};

class InterpreterHold {
 public:
  InterpreterHold() = default;

 private:
  static const ThreadState& of_this_thread() {
    static thread_local const ThreadState state;
    return state;
  }

  [[maybe_unused]] const ThreadState& state_ = of_this_thread();  // before the hold
  pybind11::gil_scoped_acquire hold_;
};

}  // namespace firn::python
