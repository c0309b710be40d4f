#include "drivers/link/dialect.h"

namespace firn::drivers {
namespace {

bool is_same_line(const Dialect& dialect, std::span<const std::byte> frame, std::string_view request) {
  return !request.empty() && text_of(frame) == cleaned(request, dialect.line_end());
}

}  // namespace

Frame frame_of(const Dialect& dialect, std::span<const std::byte> buffer, const Request* awaited,
               std::string_view before) {
  Frame f = dialect.frame(buffer, awaited);
  if (f.kind != Frame::Kind::kCorrupt || !awaited || dialect.line_end() == 0) return f;
  const auto line = buffer.first(f.size);
  if (is_same_line(dialect, line, awaited->text()) || is_same_line(dialect, line, before))
    f.kind = Frame::Kind::kIgnore;
  return f;
}

bool is_whole_reply(const Dialect& dialect, const Request& asked, std::string_view heard) {
  const char end = dialect.line_end();
  const std::string text = end == 0 ? std::string(heard) : cleaned(heard, end);
  auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  while (!bytes.empty()) {
    const Frame f = frame_of(dialect, bytes, &asked);
    if (f.kind != Frame::Kind::kIgnore) return f.kind == Frame::Kind::kReply;
    bytes = bytes.subspan(f.size);
  }
  return false;
}

}  // namespace firn::drivers
