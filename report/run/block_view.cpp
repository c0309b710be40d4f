#include "report/run/block_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "report/draw/raster.h"
#include "report/draw/svg.h"

namespace firn::report {
namespace {

using Vec = std::array<double, 3>;

enum class Look { kObject, kSupport, kOutside, kMissing, kAir };

// Okabe and Ito's hues: distinct for all.
Rgba color(Look look) {
  switch (look) {
    case Look::kObject:
      return {58, 128, 186, 255};
    case Look::kSupport:
      return {233, 222, 190, 255};
    case Look::kOutside:
      return {213, 94, 0, 255};
    case Look::kMissing:
      return {150, 20, 110, 255};
    case Look::kAir:
      return {0, 0, 0, 0};
  }
  return {0, 0, 0, 0};
}

Look look_of(Material wanted, Material printed) {
  if (printed == Material::kA) return wanted == Material::kA ? Look::kObject : Look::kOutside;
  if (wanted == Material::kA) return Look::kMissing;
  return printed == Material::kB ? Look::kSupport : Look::kAir;
}

// An orthographic eye: unit vectors to the right, up and into the picture.
struct Eye {
  Vec right, up, ahead;
  Eye() {
    constexpr double kTurn = 0.62, kDown = 0.60;  // rad: around z from -y towards +x, and down
    const double c = std::cos(kTurn), s = std::sin(kTurn), cd = std::cos(kDown), sd = std::sin(kDown);
    right = {c, s, 0.0};
    ahead = {-s * cd, c * cd, -sd};
    up = {-s * sd, c * sd, cd};
  }
};

// Walks a ray from voxel to voxel [Amanatides and Woo 1987] up to the first voxel where solid(i, j, k) is
// true. Returns the axis of the face that is hit, or -1; `cell` is the voxel.
template <class Solid>
int first_hit(Vec at, const Vec& way, const std::array<int, 3>& size, const Solid& solid,
              std::array<int, 3>& cell) {
  double enter = 0.0, leave = std::numeric_limits<double>::infinity();
  int axis = -1;
  for (int a = 0; a < 3; ++a) {
    if (way[std::size_t(a)] == 0.0) continue;
    double t0 = -at[std::size_t(a)] / way[std::size_t(a)],
           t1 = (size[std::size_t(a)] - at[std::size_t(a)]) / way[std::size_t(a)];
    if (t0 > t1) std::swap(t0, t1);
    if (t0 > enter) {
      enter = t0;
      axis = a;
    }
    leave = std::min(leave, t1);
  }
  if (enter >= leave) return -1;
  Vec next{}, step{};
  for (std::size_t a = 0; a < 3; ++a) {
    at[a] += enter * way[a];
    cell[a] = std::clamp(int(std::floor(at[a])), 0, size[a] - 1);
    step[a] = way[a] != 0.0 ? std::abs(1.0 / way[a]) : std::numeric_limits<double>::infinity();
    next[a] = way[a] > 0.0   ? (cell[a] + 1 - at[a]) / way[a]
              : way[a] < 0.0 ? (cell[a] - at[a]) / way[a]
                             : step[a];
  }
  for (;;) {
    if (solid(cell[0], cell[1], cell[2])) return axis;
    axis = next[0] <= next[1] && next[0] <= next[2] ? 0 : next[1] <= next[2] ? 1 : 2;
    const std::size_t a = std::size_t(axis);
    cell[a] += way[a] > 0.0 ? 1 : -1;
    if (cell[a] < 0 || cell[a] >= size[a]) return -1;
    next[a] += step[a];
  }
}

Rgba shaded(Rgba c, double light) {
  for (std::size_t n = 0; n < 3; ++n) c[n] = std::uint8_t(std::clamp(c[n] * light, 0.0, 255.0));
  return c;
}

// Removes the empty rows and columns around the drawing.
Raster cropped(Raster& raster) {
  int left = raster.width, right = 0, top = raster.height, bottom = 0;
  for (int y = 0; y < raster.height; ++y)
    for (int x = 0; x < raster.width; ++x)
      if (raster.at(x, y)[3] != 0) {
        left = std::min(left, x);
        right = std::max(right, x + 1);
        top = std::min(top, y);
        bottom = std::max(bottom, y + 1);
      }
  Raster out(std::max(1, right - left), std::max(1, bottom - top));
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) out.at(x - left, y - top) = raster.at(x, y);
  return out;
}

std::string legend(double x, double y, std::initializer_list<Look> looks) {
  std::string s;
  for (const Look look : looks) {
    const Rgba c = color(look);
    const char* name = look == Look::kObject    ? "object"
                       : look == Look::kSupport ? "support"
                       : look == Look::kOutside ? "object ink outside M"
                                                : "no object ink inside M";
    char box[120];
    std::snprintf(box, sizeof box,
                  "<rect x=\"%.1f\" y=\"%.1f\" width=\"12\" height=\"12\" fill=\"#%02x%02x%02x\"/>\n", x,
                  y - 10, c[0], c[1], c[2]);
    s += box + svg_text(x + 17, y, "start", "tick", name);
    x += 30 + 7.0 * double(std::char_traits<char>::length(name));
  }
  return s;
}

}  // namespace

double z_stretch(const VoxelBlock& b) { return b.grid.pitch_x_mm / b.slice_mm; }

std::string section_view(const VoxelBlock& wanted, const std::vector<NamedBlock>& blocks, int section_i,
                         const std::string& title) {
  constexpr double kCell = 3.4, kLeft = 42, kGap = 26, kRowGap = 34, kTop = 22;
  const GridSpec& g = wanted.grid;
  const double wide = kCell * g.nx, deep = kCell * g.ny, high = kCell * wanted.nz;
  const double right = kLeft + wide + kGap;
  const double row = high + kRowGap;
  std::string s = svg_open(right + deep + 12, kTop + row * double(blocks.size()) + 42, title);
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    const VoxelBlock& b = *blocks[n].block;
    const double top = kTop + row * double(n);
    Raster along(g.nx, wanted.nz), across(g.ny, wanted.nz);
    for (int k = 0; k < wanted.nz; ++k) {
      for (int i = 0; i < g.nx; ++i)
        along.at(i, wanted.nz - 1 - k) =
            color(look_of(wanted.at(i, g.ny / 2, k), b.at_or_none(i, g.ny / 2, k)));
      for (int j = 0; j < g.ny; ++j)
        across.at(j, wanted.nz - 1 - k) =
            color(look_of(wanted.at(section_i, j, k), b.at_or_none(section_i, j, k)));
    }
    s += svg_text(kLeft, top - 7, "start", "name", blocks[n].name);
    s += svg_image(along, kLeft, top, wide, high) + svg_image(across, right, top, deep, high);
    char line[200];
    for (const double um :
         {0.0, 0.5 * wanted.nz * wanted.slice_mm * 1e3, wanted.nz * wanted.slice_mm * 1e3}) {
      const double y = top + high - um * 1e-3 / wanted.slice_mm * kCell;
      std::snprintf(line, sizeof line, "<path class=\"axis\" d=\"M%.1f %.1fh-4\"/>", kLeft, y);
      s += line + svg_text(kLeft - 6, y + 4, "end", "tick", number(um, 0));
    }
  }
  const double bottom = kTop + row * double(blocks.size()) - kRowGap;
  for (int tenth = 0; tenth <= 25; tenth += 5) {
    const double at = tenth / g.pitch_x_mm * kCell;
    if (at > wide) break;
    s += svg_text(kLeft + at, bottom + 15, "middle", "tick", number(tenth, 0));
    s += svg_text(right + at, bottom + 15, "middle", "tick", number(tenth, 0));
  }
  s += svg_text(kLeft + wide / 2, bottom + 32, "middle", "name", "x [mm], in the middle of y; z [um]");
  s += svg_text(right + deep / 2, bottom + 32, "middle", "name",
                "y [mm], at x = " + number(g.x_mm(section_i), 1) + " mm");
  return s + legend(kLeft, bottom + 56, {Look::kObject, Look::kSupport, Look::kOutside, Look::kMissing}) +
         "</svg>\n";
}

std::string block_view(const VoxelBlock& wanted, const VoxelBlock& printed, const BlockViewOptions& options,
                       const std::string& title) {
  constexpr int kWidth = 900;      // pixels of the whole block
  constexpr double kDrawn = 0.75;  // units of the drawing per pixel
  const Eye eye;
  const GridSpec& g = printed.grid;
  const std::array<int, 3> size{g.nx, g.ny, printed.nz};
  const Vec middle{0.5 * g.nx, 0.5 * g.ny, 0.5 * printed.nz};
  double half_width = 0.0, half_height = 0.0;  // of the box's shadow
  for (std::size_t a = 0; a < 3; ++a) {
    half_width += 0.5 * size[a] * std::abs(eye.right[a]);
    half_height += 0.5 * size[a] * std::abs(eye.up[a]);
  }
  const double px = 2.0 * half_width / (kWidth - 20);
  const int height = int(2.0 * half_height / px) + 20;
  const auto shown = [&](int i, int j, int k) {
    const Material m = printed.at(i, j, k);
    if (m == Material::kA) return true;
    const bool near_quarter = 2 * i > g.nx && 2 * j < g.ny;
    return options.support && m == Material::kB && !near_quarter;
  };
  Raster raster(kWidth, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double a = (x + 0.5 - 0.5 * kWidth) * px, b = (0.5 * height - y - 0.5) * px,
                   far = -2.0 * (g.nx + g.ny + printed.nz);
      Vec at{};
      for (std::size_t n = 0; n < 3; ++n)
        at[n] = middle[n] + a * eye.right[n] + b * eye.up[n] + far * eye.ahead[n];
      std::array<int, 3> cell{};
      const int axis = first_hit(at, eye.ahead, size, shown, cell);
      if (axis < 0) continue;
      const auto [i, j, k] = cell;
      constexpr double kLight[3] = {0.82, 0.62, 1.0};
      const double relief =
          axis == 2 ? 0.84 + 0.16 * (k + 1.0) / printed.nz : 1.0;  // higher tops are lighter
      raster.at(x, y) =
          shaded(color(look_of(wanted.at_or_none(i, j, k), printed.at(i, j, k))), kLight[axis] * relief);
    }
  const Raster seen = cropped(raster);
  const double wide = std::max(kDrawn * seen.width, 400.0), high = kDrawn * seen.height;
  const std::string s = svg_open(wide, high + 34, title) +
                        svg_image(seen, 0.5 * (wide - kDrawn * seen.width), 0, kDrawn * seen.width, high);
  const std::string names =
      options.support ? legend(12, high + 24, {Look::kObject, Look::kSupport, Look::kOutside, Look::kMissing})
                      : legend(12, high + 24, {Look::kObject, Look::kOutside});
  return s + names + "</svg>\n";
}

}  // namespace firn::report
