#include "page/bundle.h"

#include <zlib.h>

#include <algorithm>
#include <stdexcept>

namespace firn::page {

const Asset* find_asset(std::string_view path) {
  const auto all = assets();
  const auto found = std::ranges::find(all, path, &Asset::path);
  return found == all.end() ? nullptr : &*found;
}

std::string plain(const Asset& asset) {
  z_stream z{};
  constexpr int kGzip = 16 + MAX_WBITS;
  if (inflateInit2(&z, kGzip) != Z_OK) throw std::runtime_error("zlib cannot begin");
  z.next_in = const_cast<unsigned char*>(asset.gzip.data());
  z.avail_in = unsigned(asset.gzip.size());
  std::string text;
  int status = Z_OK;
  while (status == Z_OK) {
    unsigned char chunk[16384];
    z.next_out = chunk;
    z.avail_out = sizeof chunk;
    status = inflate(&z, Z_NO_FLUSH);
    text.append(reinterpret_cast<const char*>(chunk), sizeof chunk - z.avail_out);
  }
  inflateEnd(&z);
  if (status != Z_STREAM_END)
    throw std::runtime_error(std::string(asset.path) + ": is damaged in this program");
  return text;
}

}  // namespace firn::page
