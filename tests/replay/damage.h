// Changes recorded files, with and without mending the checksums.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "tests/files/record/scratch.h"

namespace firn::test {

struct RawRecord {
  std::uint16_t kind = 0;
  std::vector<std::byte> payload;
};
using Records = std::vector<RawRecord>;

Records read_records(const std::filesystem::path& file);
/// The file made anew, with right checksums and indices.
void write_records(const std::filesystem::path& file, const Records& records);
/// write_records(edit(read_records))
void edit_records(const std::filesystem::path& file, const std::function<void(Records&)>& edit);

/// Returns the position in `records` of the n-th (0-based) one of that kind whose payload contains `text`;
/// outputs are searched for the channel they send on. @throws std::runtime_error if there is no such record
std::size_t find_record(const Records& records, std::uint16_t kind, std::string_view text, int n);

void write_bytes(const std::filesystem::path& file, const std::vector<std::byte>& bytes);
/// Flips bit `bit` of the byte that stands `from_end` bytes before the end of the n-th occurrence's record or
/// event.
void flip(std::vector<std::byte>& bytes, std::size_t at, int bit = 0);
/// First place of `needle` in `bytes` from `from` on. @throws std::runtime_error if there is none
std::size_t find_bytes(const std::vector<std::byte>& bytes, const std::vector<std::byte>& needle,
                       std::size_t from = 0);

/// Adds `by` to the step number of an event or outputs record.
void renumber(RawRecord& record, std::int64_t by);

}  // namespace firn::test
