// Packs the files of a finished run: zstd over a shorter writing of record files, with the messages of
// log.lcm as known text, since write-ahead files repeat them. MappedFile unpacks, so that every reader of
// plain files reads packed ones. Format: docs/formats.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "files/record/pages.h"

namespace firn::record {

/// Returns true if the bytes begin as a packed file does.
bool is_packed(std::span<const std::byte> bytes);
/// The same of a file; false if it cannot be read.
bool is_packed(const std::filesystem::path& file);

/// Damage of a packed file, or of the file that it needs: exit code 2 of every command.
struct PackedError : std::runtime_error {
  using runtime_error::runtime_error;
};

/// Packs one part of a file after the other. Every part is unpacked and compared as it is written.
/// @param known bytes of the file `known_name`; empty: none. They are used where the squeezed file
/// has them in long messages and fits into the window of kWindow_bytes. Packing and unpacking hold such a
/// window and a record in memory, of other files 4 MiB
/// @param known_name "log.lcm" or "../log.lcm", from the folder of the packed file; empty: none
/// @param write receives the packed bytes in their order, kHeaderBytes of zeros first
/// @param goes_on is told now and then how many plain bytes were read, of each twice; false ends the packing
/// @returns the header, which takes the place of those zeros; nothing where the packing was ended, would save
/// nothing, or is so small that unpack() would refuse it
/// @throws std::runtime_error: zstd's error, or other bytes after unpacking; any of write
inline constexpr std::size_t kHeaderBytes = 48, kWindow_bytes = std::size_t(64) << 20;
using PackedHeader = std::array<std::byte, kHeaderBytes>;
std::optional<PackedHeader> pack(std::span<const std::byte> plain, std::span<const std::byte> known,
                                 const std::string& known_name,
                                 const std::function<void(std::span<const std::byte>)>& write,
                                 const std::function<bool(std::size_t)>& goes_on = {});
/// The same in memory, also where it saves nothing. @returns empty bytes in place of nothing
std::vector<std::byte> pack(std::span<const std::byte> plain, std::span<const std::byte> known,
                            const std::string& known_name);

/// Returns the number of plain bytes that a packed file declares; nothing for other bytes.
std::optional<std::uint64_t> declared_bytes(std::span<const std::byte> packed);

/// PackedReader reads the plain bytes of a packed file from its begin to its end, with zstd's window and one
/// record in memory: 4 MiB, with a known file up to 64, of files of Firn 0.1 up to their size.
class PackedReader {
 public:
  /// @param file the packed file, whose folder the known file is named from
  /// @param packed its bytes, which must outlive the reader
  /// @throws PackedError naming the file and what is damaged, missing or beyond its bounds; nothing is
  /// unpacked that the sizes of packed and known file do not account for
  PackedReader(const std::filesystem::path& file, std::span<const std::byte> packed);
  ~PackedReader();
  std::uint64_t plain_bytes() const;
  /// Returns the next plain bytes, which are valid until the next call; empty at the end.
  /// @throws PackedError, at the end also where the bytes have another checksum
  std::span<const std::byte> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the plain bytes of a packed file. @throws as PackedReader
Pages unpack(const std::filesystem::path& file, std::span<const std::byte> packed);

}  // namespace firn::record
