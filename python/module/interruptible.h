// interruptible() runs a long computation so that Python's signals are handled meanwhile.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <future>

#include "python/host/c_locale.h"

namespace firn::python {

/// Calls job(stop) on a thread without the interpreter's lock. `stop` is set at Ctrl-C, which then is raised
/// in Python when the job has ended.
template <class Job>
auto interruptible(Job job) {
  std::atomic<bool> stop = false;
  bool raised = false;
  std::future<decltype(job(stop))> done;
  {
    const pybind11::gil_scoped_release others_go_on;
    done = std::async(std::launch::async, [&] {
      const CLocale numbers_have_a_point;
      return job(stop);
    });
    while (done.wait_for(std::chrono::milliseconds(raised ? 1000 : 50)) != std::future_status::ready) {
      if (raised) continue;
      const pybind11::gil_scoped_acquire interpreter;
      raised = PyErr_CheckSignals() != 0;
      stop = raised;
      if (raised) PyErr_Clear();
    }
  }
  if (raised) {
    try {
      done.get();
    } catch (const std::exception&) {  // of the interruption
    }
    PyErr_SetNone(PyExc_KeyboardInterrupt);
    throw pybind11::error_already_set();
  }
  return done.get();
}

}  // namespace firn::python
