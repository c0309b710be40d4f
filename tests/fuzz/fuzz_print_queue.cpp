// Any text as a queue of prints: it is read or refused, and one that is read is written and read as the same.
#include <string>

#include "files/usage_error.h"
#include "print/operator/print_queue.h"
#include "tests/fuzz/require.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const std::string once = firn::to_text(firn::parse_queue(text, "queue.json"));
    firn::fuzz::require(firn::to_text(firn::parse_queue(once, "queue.json")) == once,
                        "a queue is read as written");
  } catch (const firn::UsageError&) {
  }
  return 0;
}
