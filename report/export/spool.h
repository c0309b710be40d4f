// Spool collects the bytes of many files that grow at the same time, with few of them open.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace firn::report {

/// A folder of files, removed with its content unless keep_as() gives it a name.
class Spool {
 public:
  /// @param folder is made anew; "<output>.part" @throws UsageError: it cannot be made
  explicit Spool(std::filesystem::path folder);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  /// @returns the number of the file
  std::size_t add(const std::string& name);
  /// @throws WriteError
  void append(std::size_t file, std::string_view bytes);
  std::uint64_t size(std::size_t file) const { return files_[file].written + files_[file].buffer.size(); }
  std::filesystem::path path(std::size_t file) const { return folder_ / files_[file].name; }
  void flush();  ///< @throws WriteError
  /// Flushes, and renames the folder. @throws WriteError
  void keep_as(const std::filesystem::path& target);

 private:
  static constexpr std::size_t kBuffer_bytes = 1 << 18;
  static constexpr std::size_t kAll_bytes = 64 << 20;  // of all buffers
  struct File {
    std::string name, buffer;
    std::uint64_t written = 0;
  };
  void write(File& file);

  std::filesystem::path folder_;
  std::vector<File> files_;
  std::size_t buffered_ = 0;
};

}  // namespace firn::report
