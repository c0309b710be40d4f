// Any bytes as the lines of a driver class in Python, of a GRBL board, and of a text between them: read, or
// refused.
#include <cmath>
#include <string>

#include "drivers/script/script_talk.h"
#include "drivers/stage/grbl.h"
#include "tests/fuzz/require.h"

using namespace firn::drivers;
using namespace firn::fuzz;

namespace {

void as_frames(const Dialect& dialect, std::span<const std::byte> bytes, const Request& asked) {
  while (!bytes.empty()) {
    const Frame f = dialect.frame(bytes, &asked);
    if (f.kind == Frame::Kind::kIncomplete) return;
    require(f.size > 0 && f.size <= bytes.size(), "a frame is a part of the buffer");
    bytes = bytes.subspan(f.size);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  if (const auto line = script::parse_line(text)) {
    require(line->kind == script::Line::Kind::kNote || line->call >= 1, "an answer has its number");
    for (const auto& [name, values] : line->values)
      for (const double v : values) require(!std::isinf(v), "no infinity");
  }
  require(script::decode_text(script::encode_text(text)) == text, "a text comes back");
  if (const auto report = grbl::parse_report(text))
    for (const double mm : report->place_mm) require(std::isfinite(mm), "a place is a number");
  grbl::parse_setting(text);
  grbl::meaning_of(text);
  script::ScriptDialect talk;
  as_frames(talk, std::as_bytes(std::span(text)), talk.request(7, "call 7 1 on\n", 1));
  as_frames(grbl::GrblDialect(), std::as_bytes(std::span(text)), grbl::status(1));
  as_frames(grbl::GrblDialect(), std::as_bytes(std::span(text)), grbl::line("G1 X1", 1, Repeat::kNever));
  return 0;
}
