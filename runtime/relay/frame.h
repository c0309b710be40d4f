// A frame is one piece of a relay's byte stream to another host: a datagram of the bus, a
// line for a process, a question about the clock, a piece of a file. Its kind decides which goes first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn::relay {

/// First byte of a frame behind its length. The numbers stand on the wire.
enum class FrameKind : std::uint8_t {
  kHello = 1,     ///< text: JSON of hello.h
  kLine = 2,      ///< name: process, or empty for the host itself; text: a line of its control line
  kDatagram = 3,  ///< name: channel; bytes: message and its MAC, as on the bus
  kFile = 4,      ///< name: path in the run folder; number: offset [bytes]; bytes: of the file from there on
  kAsk = 5,       ///< number: CLOCK_BOOTTIME [ns] of the asker
  kTell = 6,      ///< number: as asked; second: CLOCK_BOOTTIME [ns] of the answerer
  kTaken = 7,     ///< number: bytes of the frames taken since the beginning that go in turn
  /// name: port; number: of the piece; second: of the connection; bytes: of a simulated instrument or to it.
  kPort = 8,
};

struct Frame {
  FrameKind kind = FrameKind::kLine;
  std::string_view name;  ///< at most kMaxNameBytes; views into the reader's buffer
  std::int64_t number = 0, second = 0;
  std::span<const std::byte> bytes;  ///< at most kMaxFrameBytes with the name
  std::string_view text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
};

inline constexpr std::size_t kMaxNameBytes = 255;
inline constexpr std::size_t kMaxFrameBytes = std::size_t(1) << 20;  ///< behind the length

/// Appends the frame: length (4 bytes, big endian) of all that follows, kind (1), number and second (8 each,
/// big endian), length of the name (1), name, bytes. @throws std::length_error beyond the limits
void append_frame(const Frame& frame, std::vector<std::byte>& to);
/// Returns the size of the frame on the wire [bytes].
std::size_t wire_bytes(const Frame& frame);

/// Cuts a stream of bytes, in whatever pieces it comes, into frames.
class FrameReader {
 public:
  void add(std::span<const std::byte> bytes);
  /// Returns the next whole frame, which views this reader until the next call of any of its functions.
  /// @throws std::runtime_error naming the byte of the stream where no frame can begin
  std::optional<Frame> next();

 private:
  std::vector<std::byte> buffer_;
  std::size_t at_ = 0;        // of the next frame in the buffer
  std::uint64_t before_ = 0;  // bytes of the stream before the buffer
};

}  // namespace firn::relay
