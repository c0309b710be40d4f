#include "core/slice/paths/path_codec.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace firn::slice {
namespace {

constexpr std::size_t kMaxSettings = 65'536, kMaxMaterials = 256;
constexpr std::uint8_t kKindBits = 3, kClosedBit = 4;

std::int32_t in_range(std::int64_t value, const ByteReader& in, const char* what) {
  if (value < -kMaxPathUnits || value > kMaxPathUnits)
    in.fail(std::string(what) + " is beyond the limit of " + std::to_string(kMaxPathUnits) + " units");
  return std::int32_t(value);
}

void check(const LayerPaths& l) {
  if (l.info.size() != l.lines.size())
    throw std::invalid_argument(std::to_string(l.lines.size()) + " lines with " +
                                std::to_string(l.info.size()) + " infos");
  const auto within = [](std::int32_t v) { return v >= -kMaxPathUnits && v <= kMaxPathUnits; };
  bool ok = l.layer >= 1 && within(l.z) && l.height > 0 && within(l.height);
  for (const PathInfo& i : l.info) ok = ok && i.width >= 0 && within(i.width);
  bool all = true;
  for (const geometry::Point& p : l.lines.points) all &= within(p.x) & within(p.y);
  ok = ok && all;
  if (!ok)
    throw std::invalid_argument("layer " + std::to_string(l.layer) +
                                ": a number beyond what a path file holds");
}

constexpr std::uint32_t kMore[] = {0x0, 0x80, 0x8080, 0x808080};  // continuation bits

// Writes 0, -1, 1, -2 … as the bytes of put_varint(0, 1, 2, 3 …). Most steps take two or three bytes,
// unpredictably: numbers below 2^28 are spread over four bytes at once, of which the required number counts.
// @return the position behind them; four bytes are overwritten
[[gnu::always_inline]] inline std::byte* put_step(std::int64_t step, std::byte* to) {
  std::uint64_t v = (std::uint64_t(step) << 1) ^ std::uint64_t(step >> 63);
  if (v < 1u << 28) [[likely]] {
    const auto w = std::uint32_t(v);
    const std::size_t more = std::size_t(w > 0x7f) + (w > 0x3fff) + (w > 0x1fffff);
    const std::uint32_t bytes =
        (w & 0x7f) | (w & 0x3f80) << 1 | (w & 0x1fc000) << 2 | w >> 21 << 24 | kMore[more];
    std::memcpy(to, &bytes, sizeof bytes);
    return to + 1 + more;
  }
  for (; v >= 0x80; v >>= 7) *to++ = std::byte(v | 0x80);
  *to++ = std::byte(v);
  return to;
}

// Writes a line as differences, some hundred points at a time, without a capacity check for each.
void put_steps(std::span<const geometry::Point> line, geometry::Point& at, ByteWriter& out) {
  constexpr std::size_t kAtOnce = 256, kMaxBytes = 10;  // for 64 bits at seven a byte
  std::array<std::byte, 2 * kAtOnce * kMaxBytes> room;
  for (; !line.empty(); line = line.subspan(std::min(kAtOnce, line.size()))) {
    std::byte* to = room.data();
    for (const geometry::Point& p : line.first(std::min(kAtOnce, line.size()))) {
      to = put_step(std::int64_t(p.x) - at.x, to);
      to = put_step(std::int64_t(p.y) - at.y, to);
      at = p;
    }
    out.put_bytes(room.data(), std::size_t(to - room.data()));
  }
}

}  // namespace

std::vector<std::byte> encode(const PathFileHead& h) {
  ByteWriter out;
  out.put(kPathVersion);
  out.put(std::uint32_t(geometry::kUnitsPerMm));
  out.put(h.layers);
  out.put_text(h.made_by);
  out.put_text(h.laser);
  out.put(std::uint32_t(h.materials.size()));
  for (const PathFileHead::Material& m : h.materials) {
    out.put_text(m.name);
    out.put_text(m.tool);
  }
  const std::size_t n = std::min(h.settings.size(), kMaxSettings);
  out.put(std::uint32_t(n));
  out.put_bytes(h.settings.data(), n);
  return out.take();
}

PathFileHead decode_path_head(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  PathFileHead h;
  if (const auto version = in.get<std::uint32_t>("version"); version != kPathVersion)
    in.fail("version " + std::to_string(version) + " is unknown; this program reads version " +
            std::to_string(kPathVersion));
  if (const auto units = in.get<std::uint32_t>("units per mm"); units != std::uint32_t(geometry::kUnitsPerMm))
    in.fail(std::to_string(units) + " units per mm; this program reads " +
            std::to_string(geometry::kUnitsPerMm));
  h.layers = in.get<std::int32_t>("layers");
  if (h.layers < 0) in.fail(std::to_string(h.layers) + " layers");
  h.made_by = in.get_text("made_by");
  h.laser = in.get_text("laser");
  const std::size_t materials = in.get_count("number of materials", kMaxMaterials);
  for (std::size_t m = 0; m < materials; ++m) {
    h.materials.emplace_back().name = in.get_text("material name");
    h.materials.back().tool = in.get_text("material tool");
  }
  h.settings = in.get_bytes(in.get_count("length of the settings", kMaxSettings), "the settings");
  in.end();
  return h;
}

std::vector<std::byte> encode(const LayerPaths& l) {
  check(l);
  ByteWriter out;
  out.reserve(32 + 8 * l.lines.size() + 5 * l.lines.points.size());
  out.put(l.layer);
  out.put(l.z);
  out.put(l.height);
  out.put(l.clipper_rings);
  out.put(std::uint32_t(l.lines.size()));
  out.put(std::uint32_t(l.lines.points.size()));
  geometry::Point at;
  for (std::size_t n = 0; n < l.lines.size(); ++n) {
    const PathInfo& i = l.info[n];
    const std::span<const geometry::Point> line = l.lines[n];
    if (line.empty())
      throw std::invalid_argument("layer " + std::to_string(l.layer) + ": a line without points");
    out.put(std::uint8_t(std::uint8_t(i.kind) | (i.closed ? kClosedBit : 0)));
    out.put(i.material);
    out.put_varint(std::uint64_t(i.width));
    out.put_varint(line.size());
    put_steps(line, at, out);
  }
  return out.take();
}

LayerPaths decode_layer_paths(std::span<const std::byte> bytes, const PathFileHead& head) {
  ByteReader in(bytes);
  LayerPaths l;
  l.layer = in.get<std::int32_t>("layer");
  if (l.layer < 1) in.fail("layer " + std::to_string(l.layer) + "; layers count from 1");
  l.z = in_range(in.get<std::int32_t>("z"), in, "z");
  l.height = in_range(in.get<std::int32_t>("height"), in, "height");
  if (l.height <= 0) in.fail("a layer height that is not above 0");
  l.clipper_rings = in.get<std::uint32_t>("rings by Clipper");
  const std::size_t paths = in.get<std::uint32_t>("number of paths"),
                    points = in.get<std::uint32_t>("number of points");
  // A path takes at least four bytes and a point two, so that allocations are bounded by the input.
  if (paths > in.left() / 4 || points > in.left() / 2)
    in.fail(std::to_string(paths) + " paths of " + std::to_string(points) +
            " points do not fit the bytes that follow");
  l.lines.points.reserve(points);
  l.lines.ends.reserve(paths);
  l.info.reserve(paths);
  geometry::Point at;
  for (std::size_t n = 0; n < paths; ++n) {
    const auto flags = in.get<std::uint8_t>("path");
    if (flags > (kKindBits | kClosedBit))
      in.fail("path " + std::to_string(n) + " has the unknown kind " + std::to_string(flags));
    PathInfo i{PathKind(flags & kKindBits), in.get<std::uint8_t>("material"), (flags & kClosedBit) != 0, 0};
    if (i.material >= head.materials.size())
      in.fail("material " + std::to_string(i.material) + "; the head names " +
              std::to_string(head.materials.size()));
    i.width = in_range(std::int64_t(std::min<std::uint64_t>(in.get_varint("width"), 1u << 31)), in, "width");
    const std::uint64_t count = in.get_varint("number of points");
    if (count == 0 || count > points - l.lines.points.size())
      in.fail("path " + std::to_string(n) + " has " + std::to_string(count) +
              " points, which the layer does not");
    for (std::uint64_t p = 0; p < count; ++p) {
      const std::int64_t dx = in.get_signed("a point"), dy = in.get_signed("a point");
      in_range(dx / 2, in, "a step");  // so that the sum cannot overflow
      in_range(dy / 2, in, "a step");
      at.x = in_range(at.x + dx, in, "x");
      at.y = in_range(at.y + dy, in, "y");
      l.lines.points.push_back(at);
    }
    l.lines.ends.push_back(std::uint32_t(l.lines.points.size()));
    l.info.push_back(i);
  }
  if (l.lines.points.size() != points)
    in.fail(std::to_string(points) + " points were announced, " + std::to_string(l.lines.points.size()) +
            " came");
  in.end();
  return l;
}

std::vector<std::byte> encode(const PathFileTotals& t) {
  ByteWriter out;
  for (std::int64_t n : {t.layers, t.paths, t.points}) out.put(n);
  out.put(std::uint32_t(t.use.size()));
  for (const MaterialUse& u : t.use) {
    out.put(u.length_mm);
    out.put(u.volume_mm3);
  }
  return out.take();
}

PathFileTotals decode_path_totals(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  PathFileTotals t;
  for (std::int64_t* n : {&t.layers, &t.paths, &t.points}) *n = in.get<std::int64_t>("a count");
  const std::size_t materials = in.get_count("number of materials", kMaxMaterials);
  for (std::size_t m = 0; m < materials; ++m) {
    MaterialUse u;
    u.length_mm = in.get_number("length", 0.0);
    u.volume_mm3 = in.get_number("volume", 0.0);
    t.use.push_back(u);
  }
  in.end();
  return t;
}

}  // namespace firn::slice
