#include "core/slice/paths/print_paths.h"

#include <algorithm>

namespace firn::slice {
namespace {

constexpr char kMagic[] = "FIRNPTH1";
constexpr std::size_t kMagicBytes = 8;

void put_record(ByteWriter& out, const std::vector<std::byte>& payload) {
  out.put(std::uint32_t(payload.size()));
  out.put_bytes(payload.data(), payload.size());
}

template <class Decode>
auto at_byte(std::size_t offset, Decode decode) {
  try {
    return decode();
  } catch (const FormatError& e) {
    throw FormatError(offset + e.offset, e.problem);
  }
}

}  // namespace

std::vector<std::byte> encode(const PrintPaths& p) {
  ByteWriter out;
  out.put_bytes(kMagic, kMagicBytes);
  out.put(std::uint32_t(p.layers.size() + 1));
  put_record(out, encode(p.head));
  for (std::size_t n = 0; n < p.layers.size(); ++n) {
    if (n > 0 && p.layers[n].layer <= p.layers[n - 1].layer)
      throw std::invalid_argument("layer " + std::to_string(p.layers[n].layer) + " stands behind layer " +
                                  std::to_string(p.layers[n - 1].layer));
    put_record(out, encode(p.layers[n]));
  }
  return out.take();
}

PrintPaths decode_print_paths(std::span<const std::byte> bytes) {
  std::size_t at = 0;
  const auto need = [&](std::size_t n, const char* what) {
    if (bytes.size() - at < n) throw FormatError(at, std::string("the bytes end within ") + what);
  };
  const auto number = [&](const char* what) {
    need(4, what);
    std::uint32_t n = 0;
    std::memcpy(&n, bytes.data() + at, 4);
    at += 4;
    return n;
  };
  need(kMagicBytes, "the signature");
  if (std::memcmp(bytes.data(), kMagic, kMagicBytes) != 0)
    throw FormatError(0, "not the paths of a print (FIRNPTH1)");
  at = kMagicBytes;
  const std::uint32_t records = number("the number of records");
  if (records < 1) throw FormatError(kMagicBytes, "no head");
  PrintPaths p;
  for (std::uint32_t n = 0; n < records; ++n) {
    const std::uint32_t length = number("a record's length");
    need(length, "a record");
    const auto payload = bytes.subspan(at, length);
    if (n == 0) {
      p.head = at_byte(at, [&] { return decode_path_head(payload); });
    } else {
      p.layers.push_back(at_byte(at, [&] { return decode_layer_paths(payload, p.head); }));
      if (n > 1 && p.layers[n - 1].layer <= p.layers[n - 2].layer)
        throw FormatError(at, "layers do not ascend");
    }
    at += length;
  }
  if (at != bytes.size()) throw FormatError(at, std::to_string(bytes.size() - at) + " bytes are left over");
  return p;
}

LayerPaths table_layer(const PrintPaths& p) {
  for (const LayerPaths& layer : p.layers) {
    if (std::none_of(layer.info.begin(), layer.info.end(),
                     [](const PathInfo& i) { return i.kind == PathKind::kMeasurement; }))
      continue;
    LayerPaths table = layer;
    table.layer = table.z = 0;
    return table;
  }
  throw std::invalid_argument(
      "paths: no layer has measurement paths, along which the table could be measured");
}

PrintPaths with_table(PrintPaths p) {
  LayerPaths table = table_layer(p);
  p.layers.insert(p.layers.begin(), std::move(table));
  return p;
}

const LayerPaths* find_layer(const PrintPaths& p, std::int32_t layer) {
  const auto found = std::lower_bound(p.layers.begin(), p.layers.end(), layer,
                                      [](const LayerPaths& l, std::int32_t n) { return l.layer < n; });
  return found != p.layers.end() && found->layer == layer ? &*found : nullptr;
}

}  // namespace firn::slice
