// The records of the write-ahead file of one node hold each event before its handler runs, and the outputs of
// the step before they leave. Framing and checksums are those of files/record/record_file.h; here is the
// meaning of the records (docs/formats.md).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/event.h"
#include "runtime/node.h"
#include "runtime/outbox.h"

namespace firn {

/// Record kinds in a write-ahead file.
enum class WalKind : std::uint16_t {
  kHead = 1,     ///< WalHead; first record of each incarnation
  kEvent = 2,    ///< step number, Event
  kOutputs = 3,  ///< step number, nanoseconds of the handler, the Outputs; missing = the step put out nothing
};

/// Largest number of an incarnation in a message's header (lcmtypes/header_t.lcm) and in a write-ahead file.
inline constexpr std::int32_t kLastIncarnation = 1'000'000;

/// Everything that is needed to build the node again.
struct WalHead {
  std::string node;
  std::int64_t run_id = 0;
  std::int32_t incarnation = 0;
  std::string commit;
  std::string platform;  ///< glibc, OpenCV, CPU dispatch: the platform of the bytes
  std::string config_toml;
  std::string type_texts;                                  ///< the .lcm files
  std::vector<std::pair<std::string, std::string>> blobs;  ///< role, sha256
};

/// Where a host writes its records: a file, or memory in tests.
class WalSink {
 public:
  virtual ~WalSink() = default;
  virtual void append(WalKind kind, std::span<const std::byte> payload) = 0;
  virtual void sync() = 0;
};

// Encoding: little endian, strings and byte ranges with a u32 length. Decoders check every length against the
// bytes that are there. @throws std::runtime_error naming the byte.
void encode_head(const WalHead& head, std::vector<std::byte>& to);
WalHead decode_head(std::span<const std::byte> payload);

void encode_event(std::uint64_t step, const Event& event, std::vector<std::byte>& to);
struct WalEvent {
  std::uint64_t step = 0;
  Event event;  ///< views into the payload
};
WalEvent decode_event(std::span<const std::byte> payload);

void encode_outputs(std::uint64_t step, std::int64_t handler_ns, const Outbox& outbox,
                    std::vector<std::byte>& to);
struct WalOutputs {
  std::uint64_t step = 0;
  std::int64_t handler_ns = 0;  ///< wall time of the handler as measured by the runner; not part of replay
  std::span<const std::byte> body;  ///< the outputs alone, which replay compares byte by byte
};
WalOutputs decode_outputs(std::span<const std::byte> payload);
std::vector<Output> decode_output_list(std::span<const std::byte> body);
/// Into `list`, whose storage is used again.
void decode_output_list(std::span<const std::byte> body, std::vector<Output>& list);
/// The body that encode_outputs would write, for comparison.
void encode_output_list(const Outbox& outbox, std::vector<std::byte>& to);

}  // namespace firn
