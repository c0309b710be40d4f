#include "core/grid/npy.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "core/options/number.h"

namespace firn {
namespace {

static_assert(std::endian::native == std::endian::little, "NPY bytes are written little endian");

struct Header {
  std::string dtype;
  NpyShape shape;
  std::size_t data_at = 0;
};

[[noreturn]] void fail(const std::string& name, std::size_t byte, const std::string& what) {
  throw std::invalid_argument(name + ": byte " + std::to_string(byte) + ": " + what);
}

// Value text after `key` in the header dictionary, e.g. 'descr': '<f8' -> "'<f8'...".
std::string_view value_of(std::string_view dict, std::string_view key, const std::string& name) {
  const std::size_t at = dict.find("'" + std::string(key) + "'");
  const std::size_t colon = at == dict.npos ? dict.npos : dict.find(':', at);
  if (colon == dict.npos) fail(name, 10, "NPY header lacks '" + std::string(key) + "'");
  std::string_view v = dict.substr(colon + 1);
  v.remove_prefix(std::min(v.find_first_not_of(' '), v.size()));
  return v;
}

int side_of(std::string_view& text, const std::string& name) {
  text.remove_prefix(std::min(text.find_first_not_of(" ,("), text.size()));
  const std::optional<std::int32_t> n = take_number<std::int32_t>(text);
  if (!n || *n < 1 || *n > kMaxGridSide)
    fail(name, 10, "NPY shape must be two sides of 1.." + std::to_string(kMaxGridSide));
  return *n;
}

Header read_header(std::span<const std::byte> bytes, const std::string& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.substr(0, 6) != std::string_view("\x93NUMPY", 6)) fail(name, 0, "not an NPY file (magic missing)");
  if (bytes.size() < 12) fail(name, bytes.size(), "NPY header is cut");
  const int major = int(bytes[6]);
  if (major != 1 && major != 2) fail(name, 6, "NPY version " + std::to_string(major) + " is not 1 or 2");
  const auto u8 = [&](std::size_t n) { return std::size_t(bytes[n]); };
  const std::size_t at = major == 1 ? 10 : 12;
  const std::size_t length =
      major == 1 ? u8(8) | u8(9) << 8 : u8(8) | u8(9) << 8 | u8(10) << 16 | u8(11) << 24;
  if (length > bytes.size() - at)
    fail(name, 8, "NPY header length " + std::to_string(length) + " runs past the end");
  const std::string_view dict = text.substr(at, length);
  Header h;
  h.data_at = at + length;
  std::string_view d = value_of(dict, "descr", name);
  const std::size_t close = d.size() > 1 && d[0] == '\'' ? d.find('\'', 1) : d.npos;
  if (close == d.npos) fail(name, at, "NPY dtype is not a plain type");
  h.dtype = d.substr(1, close - 1);
  if (!value_of(dict, "fortran_order", name).starts_with("False"))
    fail(name, at, "NPY array is in Fortran order; row-major is needed");
  std::string_view shape = value_of(dict, "shape", name);
  if (!shape.starts_with("(")) fail(name, at, "NPY shape is not a tuple");
  h.shape.ny = side_of(shape, name);
  h.shape.nx = side_of(shape, name);
  shape.remove_prefix(std::min(shape.find_first_not_of(" ,"), shape.size()));
  if (!shape.starts_with(")")) fail(name, at, "NPY array is not two-dimensional");
  return h;
}

std::size_t checked_item_size(const Header& h, std::size_t total, std::size_t item, const GridSpec& g,
                              const std::string& name) {
  const std::size_t want = std::size_t(h.shape.ny) * std::size_t(h.shape.nx) * item;
  if (total - h.data_at != want)
    fail(name, total,
         "NPY data has " + std::to_string(total - h.data_at) + " bytes, shape and dtype need " +
             std::to_string(want));
  if (h.shape.nx != g.nx || h.shape.ny != g.ny)
    fail(name, h.data_at,
         "NPY shape (" + std::to_string(h.shape.ny) + ", " + std::to_string(h.shape.nx) +
             ") is not the grid's (" + std::to_string(g.ny) + ", " + std::to_string(g.nx) + ")");
  return item;
}

std::vector<std::byte> with_header(const GridSpec& g, const std::string& dtype, const void* data,
                                   std::size_t bytes) {
  std::string dict = "{'descr': '" + dtype + "', 'fortran_order': False, 'shape': (" + std::to_string(g.ny) +
                     ", " + std::to_string(g.nx) + "), }";
  while ((10 + dict.size() + 1) % 64) dict += ' ';
  dict += '\n';
  std::string head("\x93NUMPY\x01\x00", 8);
  head += char(dict.size() & 0xff);
  head += char(dict.size() >> 8);
  head += dict;
  std::vector<std::byte> out(head.size() + bytes);
  std::memcpy(out.data(), head.data(), head.size());
  if (bytes) std::memcpy(out.data() + head.size(), data, bytes);
  return out;
}

}  // namespace

NpyShape npy_shape(std::span<const std::byte> bytes, const std::string& name) {
  return read_header(bytes, name).shape;
}

HeightMap height_map_from_npy(std::span<const std::byte> bytes, const GridSpec& g, const std::string& name) {
  const Header h = read_header(bytes, name);
  HeightMap map(g);
  if (h.dtype == "<f8") {
    checked_item_size(h, bytes.size(), 8, g, name);
    std::memcpy(map.data(), bytes.data() + h.data_at, map.size() * 8);
  } else if (h.dtype == "<f4") {
    checked_item_size(h, bytes.size(), 4, g, name);
    for (std::size_t c = 0; c < map.size(); ++c) {
      float v;
      std::memcpy(&v, bytes.data() + h.data_at + 4 * c, 4);
      map.cells[c] = v;
    }
  } else {
    fail(name, 10, "NPY dtype '" + h.dtype + "' is not '<f8' or '<f4'");
  }
  return map;
}

Mask mask_from_npy(std::span<const std::byte> bytes, const GridSpec& g, const std::string& name) {
  const Header h = read_header(bytes, name);
  if (h.dtype != "|u1" && h.dtype != "|b1")
    fail(name, 10, "NPY dtype '" + h.dtype + "' is not '|u1' or '|b1'");
  checked_item_size(h, bytes.size(), 1, g, name);
  Mask mask(g);
  std::memcpy(mask.data(), bytes.data() + h.data_at, mask.size());
  for (std::size_t c = 0; c < mask.size(); ++c)
    if (mask.cells[c] > 1)
      fail(name, h.data_at + c, "mask value " + std::to_string(mask.cells[c]) + " is not 0 or 1");
  return mask;
}

std::vector<std::byte> to_npy(const HeightMap& map) {
  return with_header(map.spec, "<f8", map.data(), map.size() * 8);
}
std::vector<std::byte> to_npy(const Grid<std::uint8_t>& map) {
  return with_header(map.spec, "|u1", map.data(), map.size());
}

}  // namespace firn
