// OpenCV's operations on masks against their definitions.
#include "core/vision/raster.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::vision;

namespace {

CellMask random_mask(RandomStream& r, int columns, int rows, double share) {
  CellMask m(columns, rows);
  for (std::uint8_t& c : m.cells) c = r.uniform() < share;
  return m;
}

bool on(const CellMask& m, int i, int j) {
  return i >= 0 && j >= 0 && i < m.columns && j < m.rows && m.cells[m.index(i, j)];
}

// Cells with the same answer that are reached from (i, j), marked in `seen`.
std::vector<int> reached(const CellMask& m, int i, int j, bool diagonal, std::vector<bool>& seen) {
  std::vector<int> cells{int(m.index(i, j))};
  seen[std::size_t(cells[0])] = true;
  for (std::size_t k = 0; k < cells.size(); ++k)
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di) {
        const int x = cells[k] % m.columns + di, y = cells[k] / m.columns + dj;
        if ((!diagonal && di != 0 && dj != 0) || x < 0 || y < 0 || x >= m.columns || y >= m.rows) continue;
        if (on(m, x, y) != on(m, i, j) || seen[m.index(x, y)]) continue;
        seen[m.index(x, y)] = true;
        cells.push_back(int(m.index(x, y)));
      }
  return cells;
}

}  // namespace

TEST_CASE("Components of a mask are its cells that touch each other, corners included, with their boxes") {
  RandomStream r(31, Purpose::kTest);
  for (int round = 0; round < 60; ++round) {
    const CellMask m = random_mask(r, 1 + int(r.below(40)), 1 + int(r.below(40)), r.uniform(0.05, 0.9));
    std::set<std::set<int>> wanted, got;
    std::vector<bool> seen(m.cells.size());
    for (int j = 0; j < m.rows; ++j)
      for (int i = 0; i < m.columns; ++i)
        if (on(m, i, j) && !seen[m.index(i, j)]) {
          const std::vector<int> cells = reached(m, i, j, true, seen);
          wanted.emplace(cells.begin(), cells.end());
        }
    for (const Component& c : components_of(m, 7, 9)) {
      std::set<int> cells;
      Component box{1 << 20, 1 << 20, -1, -1, 0, false, {}};
      for (const Run& run : c.runs)
        for (int x = run.x0; x <= run.x1; ++x) {
          cells.insert(int(m.index(x - 7, run.y - 9)));
          box.x0 = std::min(box.x0, x);
          box.x1 = std::max(box.x1, x);
          box.y0 = std::min(box.y0, run.y);
          box.y1 = std::max(box.y1, run.y);
        }
      CHECK(c.area == long(cells.size()));
      CHECK(std::tuple(c.x0, c.y0, c.x1, c.y1) == std::tuple(box.x0, box.y0, box.x1, box.y1));
      got.insert(cells);
    }
    CHECK(got == wanted);
  }
}

TEST_CASE("The distance of a cell is that to the nearest ground, and the picture's edge is no ground") {
  RandomStream r(32, Purpose::kTest);
  for (int round = 0; round < 80; ++round) {
    const CellMask m = random_mask(r, 1 + int(r.below(60)), 1 + int(r.below(30)),
                                   round % 4 == 0 ? 1.0 : 1.0 - 0.2 * r.uniform() * r.uniform());
    Silhouette s;
    s.columns = m.columns;
    s.rows = m.rows;
    s.mask = m.cells;
    s.left = r.uniform() < 0.6;
    s.right = r.uniform() < 0.6;
    s.top = r.uniform() < 0.6;
    s.bottom = r.uniform() < 0.6;
    const std::vector<int> got = squared_distances(s);
    for (int j = 0; j < m.rows; ++j)
      for (int i = 0; i < m.columns; ++i) {
        int nearest = 1 << 30;
        for (int y = s.top ? 0 : -1; y < m.rows + !s.bottom; ++y)
          for (int x = s.left ? 0 : -1; x < m.columns + !s.right; ++x)
            if (!on(m, x, y)) nearest = std::min(nearest, (x - i) * (x - i) + (y - j) * (y - j));
        REQUIRE(got[m.index(i, j)] == nearest);
      }
  }
}

TEST_CASE("A hole is ground that no path of edge neighbours joins to the outside") {
  RandomStream r(33, Purpose::kTest);
  for (int round = 0; round < 60; ++round) {
    const CellMask m = random_mask(r, 1 + int(r.below(30)), 1 + int(r.below(30)), r.uniform(0.3, 0.8));
    Silhouette s;
    s.columns = m.columns;
    s.rows = m.rows;
    s.mask = m.cells;
    fill_holes(s);
    std::vector<bool> outside(m.cells.size());
    for (int j = 0; j < m.rows; ++j)
      for (int i = 0; i < m.columns; ++i)
        if ((i == 0 || j == 0 || i == m.columns - 1 || j == m.rows - 1) && !on(m, i, j) &&
            !outside[m.index(i, j)])
          reached(m, i, j, false, outside);
    for (std::size_t k = 0; k < m.cells.size(); ++k) REQUIRE((s.mask[k] == 0) == outside[k]);
  }
}

TEST_CASE("Sums over connected cells are exact and name the sides that they reach") {
  RandomStream r(34, Purpose::kTest);
  for (int round = 0; round < 60; ++round) {
    CellMask m = random_mask(r, 2 + int(r.below(300)), 2 + int(r.below(40)), r.uniform(0.5, 1.0));
    const int i = int(r.below(std::uint32_t(m.columns))), j = int(r.below(std::uint32_t(m.rows)));
    m.cells[m.index(i, j)] = 1;
    std::vector<bool> seen(m.cells.size());
    CellSums w;
    for (const int k : reached(m, i, j, false, seen)) {
      const double x = k % m.columns, y = k / m.columns;
      w = {w.n + 1,
           w.x + x,
           w.y + y,
           w.xx + x * x,
           w.xy + x * y,
           w.yy + y * y,
           w.left || x == 0,
           w.top || y == 0,
           w.right || x == m.columns - 1,
           w.bottom || y == m.rows - 1};
    }
    const CellSums g = connected_sums(m, i, j);
    CHECK(std::tuple(g.n, g.x, g.y, g.xx, g.xy, g.yy) == std::tuple(w.n, w.x, w.y, w.xx, w.xy, w.yy));
    CHECK(std::tuple(g.left, g.top, g.right, g.bottom) == std::tuple(w.left, w.top, w.right, w.bottom));
  }
}

TEST_CASE("A dilated mask reaches three cells farther in an octagon") {
  CellMask m(15, 13);
  m.cells[m.index(7, 6)] = 1;
  const CellMask wide = dilated(m);
  for (int j = 0; j < m.rows; ++j)
    for (int i = 0; i < m.columns; ++i) {
      const int dx = std::abs(i - 7), dy = std::abs(j - 6);
      CHECK((wide.cells[wide.index(i, j)] != 0) == (std::max(dx, dy) <= 3 && dx + dy <= 4));
    }
}

TEST_CASE("An inverted picture is white less each pixel, and black above white") {
  Frame f{16, 16, 1000, std::vector<std::uint16_t>(256, 300)};
  f.pixels[5] = 0;
  f.pixels[6] = 1000;
  f.pixels[7] = 40000;
  const Frame g = inverted_frame(f);
  CHECK(g.pixels[4] == 700);
  CHECK(g.pixels[5] == 1000);
  CHECK(g.pixels[6] == 0);
  CHECK(g.pixels[7] == 0);
  CHECK(g.white == 1000);
}
