// ZipWriter writes files into a .zip, deflated, of any size (ZIP64).
// Format: PKWARE APPNOTE 6.3.9, 4.3.7, 4.3.12, 4.3.14, 4.5.3.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace firn::tables {

class ZipWriter {
 public:
  explicit ZipWriter(const std::filesystem::path& file);  ///< @throws WriteError
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  using Put = std::function<void(std::string_view)>;
  /// Adds one file, whose content `fill` puts in pieces. @throws WriteError
  void add(const std::string& name, const std::function<void(const Put&)>& fill);
  void close();  ///< writes the directory. @throws WriteError

 private:
  struct Entry {
    std::string name;
    std::uint64_t offset = 0, plain = 0, packed = 0;
    std::uint32_t crc = 0;
  };
  void write(std::string_view bytes);
  void deflate(Entry& entry, const std::function<void(const Put&)>& fill);

  std::filesystem::path path_;
  std::FILE* file_ = nullptr;
  std::uint64_t at_ = 0;
  std::vector<Entry> entries_;
};

}  // namespace firn::tables
