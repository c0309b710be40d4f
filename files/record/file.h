// File and MappedFile write and read the files of logs: whole writes, errors that name path and byte, mapped
// bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

struct iovec;

namespace firn::record {

/// A failed operation on a file. The message is "<path>: byte <offset>: <operation>: <errno text>".
class FileError : public std::runtime_error {
 public:
  FileError(const std::filesystem::path& path, std::uint64_t offset, const std::string& what, int error);
  bool disk_full() const;  ///< no space, quota used up, or file size limit reached
  const std::filesystem::path path;
  const std::uint64_t offset;
  const int error;
};

/// An open file descriptor with its path and the position at which the next write goes.
class File {
 public:
  enum class Mode {
    kCreate,  ///< refuses an existing file
    kAppend,  ///< opens or creates; the position is the end
  };
  /// Acquires an exclusive lock, so that a second writer of one file is detected. @throws FileError
  File(const std::filesystem::path& path, Mode mode);
  ~File();
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  /// Writes all bytes of `parts` at position(), by one writev() unless the kernel accepts fewer; `parts` is
  /// consumed.
  /// @throws FileError; position() is then behind the written bytes.
  void write(std::span<iovec> parts);
  /// Writes over bytes that are there; position() stays. @throws FileError
  void overwrite(std::uint64_t offset, std::span<const std::byte> bytes);
  void truncate(std::uint64_t size);  ///< and moves the position there. @throws FileError
  void sync();   ///< fdatasync, the first time of a new file its folder too. @throws FileError
  void close();  ///< @throws FileError
  std::uint64_t position() const { return position_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int fd_ = -1;
  std::uint64_t position_ = 0;
  bool folder_synced_ = false;
};

/// The plain bytes of a file, read only; a packed file (packed.h) is unpacked into memory (pages.h). The
/// mapping has the size at opening; a file that another process truncates must not be read further.
class MappedFile {
 public:
  enum class Packed { kUnpack, kAsIs };
  /// @throws FileError; PackedError (packed.h)
  explicit MappedFile(const std::filesystem::path& path, Packed packed = Packed::kUnpack);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::byte> bytes() const { return bytes_; }
  /// Takes the bytes before `offset` out of the process's memory; the system reads them again from the file
  /// where they are used. Does nothing for a small unpacked file, whose memory is all there is of it. Calls
  /// go forward; not from several threads.
  void forget_before(std::uint64_t offset) const;
  /// The same of all bytes; from any thread.
  void forget() const;
  /// Returns whether a file holds the bytes, so that forgetting does something.
  bool of_file() const { return of_file_; }

 private:
  std::span<const std::byte> bytes_;
  mutable std::uint64_t forgotten_ = 0;
  bool of_file_ = true;
};

/// Copies bytes [from, size) of the file to "<path>.torn-<n>" (first free n), synced. @returns its path.
std::filesystem::path save_torn_tail(const std::filesystem::path& path, std::span<const std::byte> tail);

/// fsync of a folder, so that a new or renamed file in it survives a power cut. @throws FileError
void sync_folder(const std::filesystem::path& folder);

}  // namespace firn::record
