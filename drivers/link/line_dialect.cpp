#include "drivers/link/line_dialect.h"

namespace firn::drivers {

Frame LineDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view all = text_of(buffer);
  const std::size_t end = all.find(end_);
  if (end == std::string_view::npos)
    return all.size() > longest_ ? Frame{Frame::Kind::kCorrupt, all.size()} : Frame{};
  const std::size_t size = end + 1;
  const auto text = size > longest_ ? std::nullopt : body(all.substr(0, size));
  if (!text) return {Frame::Kind::kCorrupt, size};
  if (!awaited) return {Frame::Kind::kUnsolicited, size};
  return {answers(*text, *awaited) ? Frame::Kind::kReply : Frame::Kind::kCorrupt, size};
}

}  // namespace firn::drivers
