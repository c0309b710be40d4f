// The files of the page and of the manual that this program holds, compressed; page/embed.py writes them
// into the build.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace firn::page {

struct Asset {
  std::string_view path;  ///< "/index.html", "/manual/safety.html"
  std::string_view type;  ///< of its content
  std::string_view etag;
  std::span<const unsigned char> gzip;
};

std::span<const Asset> assets();
/// @returns nullptr: there is no such file
const Asset* find_asset(std::string_view path);
/// Returns the plain bytes. @throws std::runtime_error: damaged
std::string plain(const Asset& asset);

}  // namespace firn::page
