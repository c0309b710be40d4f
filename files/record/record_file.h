// RecordWriter and RecordReader write and read the framed records of write-ahead files and of the world's own
// record. Records survive kill -9, are found again behind any damage, and hold their index. The framing does
// not depend on the payloads. Format: docs/formats.md.
//
//   file header, 16 bytes:  "FIRNREC1", u32 version = 1, u32 zero
//   record, little endian:  8-byte sync marker, u16 kind, u16 header check, u32 payload length, u64 index,
//                           u64 XXH64 over (kind .. index, payload); payload; zeros up to a multiple of 8
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "files/record/damage.h"
#include "files/record/file.h"
#include "files/record/sequence.h"

namespace firn::record {

inline constexpr std::size_t kRecordHeaderBytes = 32;
inline constexpr std::size_t kRecordFileHeaderBytes = 16;
inline constexpr std::size_t kMaxRecordPayloadBytes = std::size_t(1) << 30;

/// Appends records. One writev() each, no allocation, so that a record is in the kernel when append()
/// returns. With a buffer, records reach the kernel when buffer_bytes have gathered, and a killed process
/// loses the waiting ones.
class RecordWriter {
 public:
  using Mode = File::Mode;
  /// kCreate: a new file, refused if one exists. kAppend: continues behind the last valid record; a torn
  /// record behind that is first copied to "<path>.torn-<n>". A file with neither a valid header nor a valid
  /// record is refused. @throws FileError, std::runtime_error
  RecordWriter(const std::filesystem::path& path, Mode mode, std::size_t buffer_bytes = 0);
  ~RecordWriter();  ///< flushes; records of a failed write are lost: flush() reports the error

  /// @param kind the caller's; @param parts the payload in pieces, at most 14
  /// @returns the index of the record
  /// @throws FileError (path, byte, errno text) when the record could not be written whole; the file then
  /// ends with
  ///         the record before (with a buffer: before the buffer's first), and append() may be tried again.
  ///         std::invalid_argument: too many parts, too long.
  std::uint64_t append(std::uint16_t kind, std::span<const std::span<const std::byte>> parts);
  std::uint64_t append(std::uint16_t kind, std::span<const std::byte> payload) {
    return append(kind, {&payload, 1});
  }

  void flush();  ///< the buffer goes to the kernel. @throws FileError
  void sync() {
    flush();
    file_.sync();
  }  ///< fdatasync: survives a power cut. @throws FileError
  void close() {
    flush();
    file_.close();
  }  ///< @throws FileError
  std::uint64_t next_index() const { return next_index_; }
  std::uint64_t bytes() const { return file_.position() + buffer_.size(); }
  const std::filesystem::path& path() const { return file_.path(); }
  /// Returns the file to which kAppend copied a torn tail; empty without a torn tail.
  const std::filesystem::path& torn_path() const { return torn_path_; }

 private:
  void write(std::span<iovec> parts);

  File file_;
  std::size_t buffer_bytes_;
  std::vector<std::byte> buffer_;
  std::uint64_t next_index_ = 0;
  std::filesystem::path torn_path_;
};

struct Record {
  std::uint64_t index = 0;
  std::uint16_t kind = 0;
  std::uint64_t offset = 0;  ///< of the sync marker
  std::span<const std::byte> payload;
  bool damaged = false;  ///< the checksum fails though the framing holds: kind and payload may be wrong
};

/// Reads records from the bytes of a file (see MappedFile). Accepts any bytes: never crashes, linear time;
/// allocates the damage list and, once something is missing, 32 bytes per record.
class RecordReader {
 public:
  explicit RecordReader(std::span<const std::byte> file);
  /// Goes on behind a valid record of a file that has grown: `from` and `index` are valid_end() and
  /// valid_next_index() of the reader before; both 0: from the beginning.
  RecordReader(std::span<const std::byte> file, std::uint64_t from, std::uint64_t index);

  /// Returns the next record in increasing index, or nothing at the end. After damage the reader continues at
  /// the next record whose header and checksum hold; a record with a repeated index is dropped. damage()
  /// lists each of these.
  std::optional<Record> next();
  const DamageList& damage() const { return damage_; }
  /// Returns the byte behind the last valid (undamaged) record returned so far; for a file without records
  /// the byte behind the header, or 0.
  std::uint64_t valid_end() const { return valid_end_; }
  /// Returns the index that follows the last valid record.
  std::uint64_t valid_next_index() const { return valid_next_index_; }
  bool header_ok() const { return header_ok_; }

 private:
  struct Header;
  std::optional<Header> header_at(std::uint64_t at) const;
  bool may_spend(std::uint64_t bytes);
  bool checksum_holds(const Header& h);
  bool framing_holds(const Header& h);
  std::uint64_t resync(std::uint64_t from);
  bool is_stray(std::uint64_t index, std::uint64_t at);
  Record accept(const Header& h, std::uint64_t index, bool damaged);

  std::span<const std::byte> file_;
  std::uint64_t at_ = 0;
  std::uint64_t expected_ = 0;  // index of the next record
  std::uint64_t valid_end_ = 0;
  std::uint64_t valid_next_index_ = 0;
  std::uint64_t spent_in_vain_ = 0;  // bytes hashed or searched for false candidates
  bool header_ok_ = false;
  DamageList damage_;
  SequenceMap places_;  // built at the first gap
};

}  // namespace firn::record
