#include "page/map_head.h"

#include "firn/header_t.hpp"
#include "firn/height_map_t.hpp"

namespace firn::page {

std::optional<MapHead> map_head(std::span<const std::byte> message) {
  const void* bytes = message.data();
  const int size = int(message.size());
  int at = 0;
  // Calls return the bytes that they read, below 0 for too few.
  const auto read = [&](int n) {
    at += n;
    return n > 0;
  };
  std::int64_t type = 0, numbers[2] = {};
  std::int32_t counts[3] = {};
  header_t header{};
  MapHead head;
  if (!read(__int64_t_decode_array(bytes, at, size - at, &type, 1)) || type != height_map_t::getHash() ||
      !read(header._decodeNoHash(bytes, at, size - at)) ||
      !read(__int32_t_decode_array(bytes, at, size - at, counts, 3)) ||
      !read(__int64_t_decode_array(bytes, at, size - at, numbers, 2)) ||
      !read(head.grid._decodeNoHash(bytes, at, size - at)))
    return std::nullopt;
  head.utime_us = header.utime_us;
  head.layer = counts[1];
  return head;
}

}  // namespace firn::page
