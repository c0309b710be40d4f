#include "runtime/relay/frame.h"

#include <cstring>
#include <stdexcept>

namespace firn::relay {
namespace {

constexpr std::size_t kLengthBytes = 4;
constexpr std::size_t kHeadBytes = 1 + 8 + 8 + 1;  // kind, number, second, length of the name

void put(std::uint64_t v, int bytes, std::vector<std::byte>& to) {
  for (int k = bytes - 1; k >= 0; --k) to.push_back(std::byte(v >> (8 * k)));
}

std::uint64_t get(const std::byte* from, int bytes) {
  std::uint64_t v = 0;
  for (int k = 0; k < bytes; ++k) v = v << 8 | std::uint64_t(from[k]);
  return v;
}

}  // namespace

std::size_t wire_bytes(const Frame& f) { return kLengthBytes + kHeadBytes + f.name.size() + f.bytes.size(); }

void append_frame(const Frame& f, std::vector<std::byte>& to) {
  const std::size_t size = wire_bytes(f) - kLengthBytes;
  if (f.name.size() > kMaxNameBytes || size > kMaxFrameBytes)
    throw std::length_error("a frame of " + std::to_string(size) + " bytes, its name of " +
                            std::to_string(f.name.size()) + ": beyond " + std::to_string(kMaxFrameBytes) +
                            " and " + std::to_string(kMaxNameBytes));
  put(size, int(kLengthBytes), to);
  put(std::uint64_t(f.kind), 1, to);
  put(std::uint64_t(f.number), 8, to);
  put(std::uint64_t(f.second), 8, to);
  put(f.name.size(), 1, to);
  const auto name = std::as_bytes(std::span(f.name));
  to.insert(to.end(), name.begin(), name.end());
  to.insert(to.end(), f.bytes.begin(), f.bytes.end());
}

void FrameReader::add(std::span<const std::byte> bytes) {
  if (at_ > 0) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + std::ptrdiff_t(at_));
    before_ += at_;
    at_ = 0;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<Frame> FrameReader::next() {
  const std::size_t left = buffer_.size() - at_;
  if (left < kLengthBytes) return std::nullopt;
  const std::byte* const from = buffer_.data() + at_;
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error("byte " + std::to_string(before_ + at_) + " of the stream: " + why);
  };
  const std::size_t size = std::size_t(get(from, int(kLengthBytes)));
  if (size < kHeadBytes || size > kMaxFrameBytes)
    refuse("a frame of " + std::to_string(size) + " bytes, which lie in [" + std::to_string(kHeadBytes) +
           ", " + std::to_string(kMaxFrameBytes) + "]");
  if (left < kLengthBytes + size) return std::nullopt;
  const std::byte* const head = from + kLengthBytes;
  const auto kind = std::uint8_t(head[0]);
  if (kind < std::uint8_t(FrameKind::kHello) || kind > std::uint8_t(FrameKind::kPort))
    refuse("a frame of unknown kind " + std::to_string(int(kind)));
  const std::size_t name = std::size_t(head[kHeadBytes - 1]);
  if (kHeadBytes + name > size) refuse("a name longer than its frame");
  Frame f;
  f.kind = FrameKind(kind);
  f.number = std::int64_t(get(head + 1, 8));
  f.second = std::int64_t(get(head + 9, 8));
  f.name = {reinterpret_cast<const char*>(head + kHeadBytes), name};
  f.bytes = {head + kHeadBytes + name, size - kHeadBytes - name};
  at_ += kLengthBytes + size;
  return f;
}

}  // namespace firn::relay
