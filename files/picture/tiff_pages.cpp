#include "files/picture/tiff_pages.h"

#include <cstdint>
#include <optional>

namespace firn {
namespace {

constexpr std::size_t kMaxPages = 65'535;

class Reader {
 public:
  Reader(std::span<const unsigned char> file, bool big_endian) : file_(file), big_endian_(big_endian) {}
  std::optional<std::uint64_t> number(std::uint64_t at, std::size_t bytes) const {
    if (at > file_.size() || file_.size() - at < bytes) return std::nullopt;
    std::uint64_t value = 0;
    for (std::size_t n = 0; n < bytes; ++n)
      value = value << 8 | file_[std::size_t(at) + (big_endian_ ? n : bytes - 1 - n)];
    return value;
  }

 private:
  std::span<const unsigned char> file_;
  bool big_endian_;
};

}  // namespace

std::size_t tiff_pages(std::span<const unsigned char> file) {
  if (file.size() < 8 || file[0] != file[1] || (file[0] != 'I' && file[0] != 'M')) return 0;
  const Reader reader(file, file[0] == 'M');
  const auto version = reader.number(2, 2);
  const bool wide = version == 43;  // BigTIFF: offsets and counts of 8 bytes, entries of 20
  if (!wide && version != 42) return 0;
  const std::size_t offset = wide ? 8 : 4, count = wide ? 8 : 2, entry = wide ? 20 : 12;
  std::size_t pages = 0;
  for (auto at = reader.number(wide ? 8 : 4, offset); at && *at != 0 && pages < kMaxPages; ++pages) {
    const auto entries = reader.number(*at, count);
    if (!entries || *entries > file.size() / entry) break;
    at = reader.number(*at + count + entry * *entries, offset);
  }
  return pages;
}

}  // namespace firn
