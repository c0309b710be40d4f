// MemoryLimit bounds the memory that Python code may take during a call, so that a MemoryError ends the call
// and not the system the process.
#pragma once

namespace firn::python {

/// While one lives, the process may map half of the machine's memory more than it had before; of several at a
/// time the first one counts. Thread-safe.
class MemoryLimit {
 public:
  MemoryLimit();
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
};

}  // namespace firn::python
