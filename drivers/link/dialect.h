// Dialect describes the protocol of one instrument: its timeouts, the end of a frame, and whether a frame
// answers the awaited request.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "drivers/link/line_cleaner.h"

namespace firn::drivers {

/// The bytes of a frame as its characters.
inline std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Permitted reaction to the loss of a reply.
enum class Repeat : std::uint8_t {
  kRead,   ///< asks only: may be asked again
  kSetup,  ///< neither moves, fires nor lights anything, and twice is as good as once: may be sent again
  kNever,  ///< moves, arms, fires or opens: never sent again; the instrument is asked for its state
};

/// One request, without allocation. `tag` and `argument` are the driver's own names for it, `format` tells
/// its dialect how to frame and recognise the reply.
struct Request {
  static constexpr std::size_t kCapacity = 112;

  std::array<std::byte, kCapacity> bytes{};
  std::uint8_t size = 0;
  std::uint8_t format = 0;
  Repeat repeat = Repeat::kRead;
  std::uint8_t attempts = 0;  ///< times sent so far
  std::uint16_t tag = 0;
  std::int32_t argument = 0;
  std::int64_t reply_us = 0;  ///< longest wait for the first byte of the reply; 0 = the dialect's

  std::span<const std::byte> data() const { return {bytes.data(), size}; }
  std::string_view text() const { return text_of(data()); }
  /// @throws std::length_error beyond kCapacity.
  void append(std::span<const std::byte> more) {
    if (more.empty()) return;
    if (size + more.size() > kCapacity) throw std::length_error("a request is longer than 112 bytes");
    std::memcpy(bytes.data() + size, more.data(), more.size());
    size = std::uint8_t(size + more.size());
  }
  void append(std::string_view text) { append(std::as_bytes(std::span(text.data(), text.size()))); }
};

/// [us]. lock: longest time that the link may stay unusable (draining, probing) before it is opened anew;
/// write: for the request to leave the host; reply: from then to the first byte of the reply; read: between
/// bytes of a reply; quiet: silence that ends a drain; opening: silence awaited after the port was opened.
struct Timeouts {
  std::int64_t lock_us = 5'000'000;
  std::int64_t write_us = 100'000;
  std::int64_t reply_us = 1'000'000;
  std::int64_t read_us = 100'000;
  std::int64_t quiet_us = 300'000;
  std::int64_t opening_us = 0;
};

/// The first frame of a buffer: its size in bytes and its kind.
struct Frame {
  enum class Kind : std::uint8_t {
    kIncomplete,   ///< more bytes are needed; size 0
    kReply,        ///< answers the awaited request
    kUnsolicited,  ///< whole, but not an answer
    kIgnore,       ///< belongs to the answer that is still to come
    kCorrupt,      ///< bad checksum, impossible length, answer to something else
  };
  Kind kind = Kind::kIncomplete;
  std::size_t size = 0;
};

class Dialect {
 public:
  virtual ~Dialect() = default;
  /// The character that ends a line of a text protocol, whose bytes come through LineCleaner; 0: a binary
  /// protocol, whose bytes are left as they are.
  virtual char line_end() const { return 0; }
  /// @param buffer not empty @param awaited null when nothing is asked. Never returns kIncomplete for a
  /// buffer that no further byte can complete.
  virtual Frame frame(std::span<const std::byte> buffer, const Request* awaited) const = 0;
  /// A harmless question with a recognisable answer.
  virtual Request probe() const = 0;
  /// Adds the bytes of a request to `tx`. Bulk data need not be copied into requests: a dialect may write
  /// them here.
  virtual void write(const Request& request, std::vector<std::byte>& tx) const {
    tx.insert(tx.end(), request.data().begin(), request.data().end());
  }

  /// The host itself may need this long between an event and its handling: timeouts grow accordingly.
  void allow_host_latency(double seconds) {
    const auto us = std::int64_t(seconds * 1e6);
    timeouts.write_us += us;
    timeouts.read_us += us;
    timeouts.quiet_us += us;
    timeouts.lock_us += 10 * us;
  }

  Timeouts timeouts;
  int max_attempts = 3;  ///< of requests that may be repeated
  /// Replies name their request, and the instrument executes a request once however often it comes: a request
  /// without a reply is sent again at once, whatever it does, and after max_attempts the link is lost.
  /// Damaged frames are dropped.
  bool numbered = false;
};

/// As dialect.frame(); a line that answers nothing and repeats the request, or the one `before` it, is an
/// echo of the line or of its server: it is passed over.
Frame frame_of(const Dialect& dialect, std::span<const std::byte> buffer, const Request* awaited,
               std::string_view before = {});

/// Returns whether `heard`, as it came, begins with a whole reply to the request; echoes may come before it.
bool is_whole_reply(const Dialect& dialect, const Request& asked, std::string_view heard);

}  // namespace firn::drivers
