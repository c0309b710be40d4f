#include "core/grid/geometry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "core/options/range.h"

namespace firn {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr char kMagic[] = "FIRNGEO1";
constexpr std::size_t kHead = 8 + 4 + 4 + 8;

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("geometry: " + what); }

std::string name_of(const GridSpec& g, std::size_t cell) {
  return "cell (" + std::to_string(cell % std::size_t(g.nx)) + ", " +
         std::to_string(cell / std::size_t(g.nx)) + ")";
}

// The height between `low` and `high` where the solid's answer changes from the one at `low`.
double change_between(const Solid& solid, double x, double y, double low, double high, bool at_low) {
  for (int n = 0; n < 20; ++n) {
    const double middle = 0.5 * (low + high);
    (solid.contains(x, y, middle) == at_low ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

template <class T>
void put(std::vector<std::byte>& out, const T& value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), from, from + sizeof value);
}

}  // namespace

Geometry::Geometry(const GridSpec& grid, double height_mm, const std::vector<std::vector<Span>>& spans)
    : grid_(grid), height_mm_(height_mm) {
  check(grid);
  if (!(std::isfinite(height_mm) && height_mm > 0.0))
    refuse("height " + shortest_text(height_mm) + " mm must be above 0");
  if (spans.size() != grid.size())
    refuse(std::to_string(spans.size()) + " columns are not the grid's " + std::to_string(grid.size()));
  first_.reserve(spans.size() + 1);
  for (std::size_t c = 0; c < spans.size(); ++c) {
    first_.push_back(std::uint32_t(spans_.size()));
    double below = 0.0;
    for (const Span& s : spans[c]) {
      if (!(s.from_mm >= below && s.to_mm > s.from_mm && s.to_mm <= height_mm))
        refuse(name_of(grid, c) + ": span " + shortest_text(s.from_mm) + " .. " + shortest_text(s.to_mm) +
               " mm is empty, out of order or outside 0 .. " + shortest_text(height_mm));
      below = s.to_mm;
      spans_.push_back(s);
    }
  }
  first_.push_back(std::uint32_t(spans_.size()));
}

Geometry Geometry::sampled(const Solid& solid, const GridSpec& grid, double height_mm, double step_mm) {
  check(grid);
  if (!(height_mm > 0.0 && step_mm > 0.0 && height_mm / step_mm <= 1e6))
    refuse("height " + shortest_text(height_mm) + " mm and step " + shortest_text(step_mm) +
           " mm must be above 0, and no more than a million steps");
  const int steps = std::max(1, int(height_mm / step_mm + 0.5));
  std::vector<std::vector<Span>> spans(grid.size());
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      const double x = grid.x_mm(i), y = grid.y_mm(j);
      std::vector<Span>& column = spans[grid.index(i, j)];
      double low = 0.5 * height_mm / steps, from = 0.0;
      bool inside = solid.contains(x, y, low);
      for (int k = 1; k < steps; ++k) {
        const double high = (k + 0.5) * height_mm / steps;
        if (solid.contains(x, y, high) != inside) {
          const double z = change_between(solid, x, y, low, high, inside);
          if (inside)
            column.push_back({from, z});
          else
            from = z;
          inside = !inside;
        }
        low = high;
      }
      if (inside) column.push_back({from, height_mm});
    }
  return Geometry(grid, height_mm, spans);
}

Material Geometry::at(std::size_t cell, double z_mm) const {
  const std::span<const Span> column = spans(cell);
  if (z_mm >= height_mm_)
    return !column.empty() && column.back().to_mm >= height_mm_ ? Material::kA : Material::kB;
  const double z = std::max(z_mm, 0.0);
  for (const Span& s : column)
    if (z < s.to_mm) return z >= s.from_mm ? Material::kA : Material::kB;
  return Material::kB;
}

std::vector<std::byte> to_bytes(const Geometry& g) {
  std::vector<std::byte> out;
  for (const char c : std::string_view(kMagic)) out.push_back(std::byte(c));
  put(out, g.grid().nx);
  put(out, g.grid().ny);
  put(out, g.height_mm());
  for (std::size_t c = 0; c < g.grid().size(); ++c) put(out, std::uint32_t(g.spans(c).size()));
  for (std::size_t c = 0; c < g.grid().size(); ++c)
    for (const Span& s : g.spans(c)) {
      put(out, s.from_mm);
      put(out, s.to_mm);
    }
  return out;
}

Geometry geometry_from_bytes(std::span<const std::byte> bytes, const GridSpec& grid,
                             const std::string& name) {
  std::size_t at = 0;
  const auto wrong = [&](const std::string& what) {
    return std::invalid_argument(name + ": byte " + std::to_string(at) + ": " + what);
  };
  const auto take = [&](auto& value) {
    if (bytes.size() - at < sizeof value) throw wrong("the geometry is cut short");
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
  };
  if (bytes.size() < kHead || std::memcmp(bytes.data(), kMagic, 8) != 0)
    throw wrong("no geometry (FIRNGEO1)");
  at = 8;
  std::int32_t nx = 0, ny = 0;
  double height_mm = 0.0;
  take(nx);
  take(ny);
  take(height_mm);
  if (nx != grid.nx || ny != grid.ny)
    throw wrong("a grid of " + std::to_string(nx) + " x " + std::to_string(ny) + " is not the experiment's " +
                std::to_string(grid.nx) + " x " + std::to_string(grid.ny));
  std::vector<std::uint32_t> counts(grid.size());
  for (std::uint32_t& n : counts) take(n);
  std::size_t left = (bytes.size() - at) / (2 * sizeof(double));
  std::vector<std::vector<Span>> spans(grid.size());
  for (std::size_t c = 0; c < counts.size(); ++c) {
    if (counts[c] > left) throw wrong("the geometry is cut short");
    left -= counts[c];
    spans[c].resize(counts[c]);
    for (Span& s : spans[c]) {
      take(s.from_mm);
      take(s.to_mm);
    }
  }
  if (at != bytes.size()) throw wrong("bytes left over at the end");
  try {
    return Geometry(grid, height_mm, spans);
  } catch (const std::invalid_argument& e) {
    throw wrong(e.what());
  }
}

}  // namespace firn
