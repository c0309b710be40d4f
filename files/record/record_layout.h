// RecordLayout holds the bytes of a record header, shared by writer and reader.
#pragma once

#include <array>
#include <bit>
#include <cstring>

#include "files/record/checksum.h"
#include "files/record/record_file.h"

namespace firn::record {

static_assert(std::endian::native == std::endian::little, "record files are written little endian");

inline constexpr std::array<unsigned char, 8> kSyncMarker{0xf1, 0x52, 0x4e, 0x9d, 0xe7, 0x3a, 0xc6, 0x0b};
inline constexpr std::array<unsigned char, kRecordFileHeaderBytes> kFileHeader{
    'F', 'I', 'R', 'N', 'R', 'E', 'C', '1', 1, 0, 0, 0, 0, 0, 0, 0};

struct RecordLayout {
  std::array<unsigned char, 8> sync;
  std::uint16_t kind;
  std::uint16_t check;  // of kind, length and index: distinguishes a damaged header from a damaged payload
  std::uint32_t length;
  std::uint64_t index;
  std::uint64_t checksum;

  std::uint16_t expected_check() const {
    const std::uint64_t fields[2] = {std::uint64_t(kind) << 32 | length, index};
    const std::uint64_t h = checksum64(std::as_bytes(std::span(fields)));
    return std::uint16_t(h ^ h >> 16 ^ h >> 32 ^ h >> 48);
  }
  /// Returns the part of the header that the checksum covers.
  std::span<const std::byte> covered() const {
    return {reinterpret_cast<const std::byte*>(this) + offsetof(RecordLayout, kind),
            offsetof(RecordLayout, checksum) - offsetof(RecordLayout, kind)};
  }
};
static_assert(sizeof(RecordLayout) == kRecordHeaderBytes);

inline std::uint64_t padded(std::uint64_t bytes) { return (bytes + 7) / 8 * 8; }

}  // namespace firn::record
