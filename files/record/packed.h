// Packs the files of a finished run: zstd over a shorter writing of record files, with the messages of
// log.lcm as known text, since write-ahead files repeat them. MappedFile unpacks, so that every reader of
// plain files reads packed ones. Format: docs/formats.md.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "files/record/pages.h"

namespace firn::logfile {

/// Returns true if the bytes begin as a packed file does.
bool is_packed(std::span<const std::byte> bytes);
/// The same of a file; false if it cannot be read.
bool is_packed(const std::filesystem::path& file);

/// Returns the content of a packed file.
/// @param known bytes of the file `known_name`; empty: none
/// @param known_name "log.lcm" or "../log.lcm", from the folder of the packed file; empty: none
/// @throws std::runtime_error: zstd's error
std::vector<std::byte> pack(std::span<const std::byte> plain, std::span<const std::byte> known,
                            const std::string& known_name);

/// Returns the plain bytes. Of a large file the process holds some 100 MB at a time.
/// @param file the packed file, whose folder the known file is named from
/// @throws std::runtime_error naming the file and what is damaged or missing
Pages unpack(const std::filesystem::path& file, std::span<const std::byte> packed);

/// A record file without what follows from the rest of it: sync markers, checksums, indices, padding. Bytes
/// that are no valid record stay as they are.
std::vector<std::byte> squeeze_records(std::span<const std::byte> plain);
/// Bytes of the squeezed form before those of a file that is one piece without records: a log.
inline constexpr std::size_t kPieceHeadBytes = 5;
/// Returns true if `squeezed` is one such piece: its plain bytes follow its head.
bool is_one_piece(std::span<const std::byte> squeezed);
/// Writes the record file again. @returns false if `squeezed` is damaged or `plain` has another size
/// @param done is told now and then how many bytes of both are done with
bool restore_records(std::span<const std::byte> squeezed, std::span<std::byte> plain,
                     const std::function<void(std::size_t read, std::size_t written)>& done = {});

}  // namespace firn::logfile
