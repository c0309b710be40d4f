// FileSource and FileSink carry files of a run folder to another host's copy of it, piece by piece, while
// they grow.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/relay/frame.h"

namespace firn::relay {

class FileSource {
 public:
  explicit FileSource(std::filesystem::path run) : run_(std::move(run)) {}
  ~FileSource();
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  /// Sends the file, which need not exist yet, from byte `from` on.
  void add(const std::string& name, std::int64_t from);
  /// Sees how far the files have grown. @throws std::runtime_error naming a file that cannot be read
  void look();
  /// Makes the next piece of the bytes that look() saw, file by file in turn. Returns false if there is none.
  bool next(std::vector<std::byte>& frame);
  bool all_sent() const;

  static constexpr std::size_t kPieceBytes = 32 << 10;

 private:
  struct Source {
    std::string name;
    int fd = -1;
    std::int64_t sent = 0, seen = 0;
    bool begun = false;  // an empty file is sent too
  };
  std::filesystem::path run_;
  std::vector<Source> files_;
  std::size_t turn_ = 0;
  std::vector<std::byte> piece_;
};

class FileSink {
 public:
  /// @param takes whether a file of this name may be written: the other host is not trusted with more
  FileSink(std::filesystem::path run, std::function<bool(std::string_view name)> takes)
      : run_(std::move(run)), takes_(std::move(takes)) {}
  /// Appends a piece; one at byte 0 begins the file anew, but a write-ahead file.
  /// @throws std::runtime_error naming the file: not to be taken, a piece that does not follow, no space
  void take(const Frame& piece);

 private:
  std::filesystem::path run_;
  std::function<bool(std::string_view name)> takes_;
};

/// Size and SHA-256 of a file of the run; size -1: there is none.
struct FileState {
  std::int64_t bytes = -1;
  std::string sha256;
  bool operator==(const FileState&) const = default;
};
/// @param most of its first bytes count; -1: all
FileState state_of(const std::filesystem::path& file, std::int64_t most = -1);

}  // namespace firn::relay
