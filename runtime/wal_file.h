// WalFile writes the write-ahead file of a live node, which is read back at a resume.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "files/record/record_file.h"
#include "runtime/node_host.h"
#include "runtime/write_ahead.h"

namespace firn {

class WalFile : public WalSink {
 public:
  /// @param resume false: a new file, refused if there is one; true: goes on behind the last whole record.
  /// @param buffer_bytes of record::RecordWriter; above 0 only where no instrument outlives the process:
  /// sync() then waits
  ///        for no disk
  WalFile(const std::filesystem::path& path, bool resume, std::size_t buffer_bytes = 0);
  void append(WalKind kind, std::span<const std::byte> payload) override;
  void sync() override;
  void flush() { writer_.flush(); }
  const std::filesystem::path& path() const { return writer_.path(); }

 private:
  record::RecordWriter writer_;
  bool buffered_;
};

/// The contents of the file for a resume, in the order of the records.
struct RestoreSinks {
  std::function<void(const WalHead&)> head;
  std::function<void(std::string_view channel, std::span<const std::byte>)>
      received;  ///< message that was handled
  std::function<void(std::string_view channel, std::span<const std::byte>)>
      sent;  ///< message that was put out
  /// Message of the last step, whose outputs were never written: it goes out now, for the first time. Bytes
  /// for instruments of that step do not go out: whether they did before is not known, and the driver asks.
  std::function<void(std::string_view channel, std::span<const std::byte>)> unsent;
};

/// The CONFIG_ message of an incarnation, made from the head of its write-ahead file: seq = incarnation + 1,
/// utime 0.
std::vector<std::byte> config_message(const WalHead& head);

/// Runs `host` through everything that `file` holds and compares every output byte; the outputs of a last
/// step that were never written are appended. @returns the largest `now`.
/// @throws std::runtime_error naming file, step and event: damage before the end, an output that differs, an
/// event
///         that crashes the node again, a file of another node or run.
Time restore(NodeHost& host, std::int64_t run_id, WalFile& file, const RestoreSinks& sinks);

/// The message (channel, seq) among the outputs in a write-ahead file; false if it is not there.
bool find_sent(const std::filesystem::path& path, std::string_view channel, std::int64_t seq,
               std::vector<std::byte>& to);

/// "LAYER_PLAN seq 3", "wake-up 2", "128 bytes from port 0", …
std::string describe(const Event& event);

}  // namespace firn
