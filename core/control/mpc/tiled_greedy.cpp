#include "core/control/mpc/tiled_greedy.h"

#include <algorithm>
#include <vector>

#include "core/control/halftone.h"
#include "core/control/mpc/greedy.h"
#include "core/control/mpc/layer/one_layer.h"
#include "core/control/mpc/objective.h"
#include "core/grid/random.h"

namespace firn::control::mpc {
namespace {

// A tile's sums, 250 bytes a cell, stay in a processor's cache.
constexpr int kTileCells = 128;
// A droplet changes the errors of its neighbours, and these depend on the droplets of theirs.
constexpr int kSurroundings = 2;
// A droplet that changed beside a tile seldom changes others further inside than this.
constexpr int kRimCells = 8;

struct Box {
  int left, bottom, right, top;  // right and top lie beyond it
  int nx() const { return right - left; }
  int ny() const { return top - bottom; }
};

class Tiles {
 public:
  Tiles(const Setup& setup, const HeightMap& height, const MpcOptions& options, int layer, int attempt,
        const ParallelFor& parallel)
      : setup_(setup),
        height_(height),
        options_(options),
        layer_(layer),
        attempt_(attempt),
        parallel_(parallel),
        along_x_((setup.grid.nx + kTileCells - 1) / kTileCells),
        along_y_((setup.grid.ny + kTileCells - 1) / kTileCells),
        drops_(setup.grid),
        stale_(std::size_t(along_x_) * std::size_t(along_y_), kWhole) {}

  TiledLayer run() {
    parallel_(int(stale_.size()), [&](int tile) { guess(tile); });
    TiledLayer out;
    for (std::uint32_t pass = 0; waiting() > 0 && out.evaluations < options_.max_evaluations; ++pass)
      for (int colour = 0; colour < 4; ++colour) search_colour(colour, pass, out);
    out.optimal = waiting() == 0;
    out.drops = std::move(drops_);
    out.objective_mm = mean_error_mm(setup_, height_, out.drops);
    if (options_.outside_price > 0.0)
      out.objective_mm +=
          options_.outside_price * outside_rise_mm(setup_, height_, out.drops) / double(part_cells());
    return out;
  }

 private:
  enum Stale : std::uint8_t {
    kNone,
    kRim,
    kWhole
  };  // cells of a tile of which a change may better the layer
  struct Searched {
    std::int64_t evaluations = 0;
    std::vector<std::uint32_t> changed;  // cells of the grid
    Stale stale = kNone;
  };

  std::int64_t waiting() const {
    return std::ranges::count_if(stale_, [](Stale s) { return s != kNone; });
  }

  // Tiles of one colour have another tile between them.
  void search_colour(int colour, std::uint32_t pass, TiledLayer& out) {
    std::vector<int> tiles;
    for (int tile = 0; tile < int(stale_.size()); ++tile)
      if (stale_[std::size_t(tile)] && tile % along_x_ % 2 == colour % 2 && tile / along_x_ % 2 == colour / 2)
        tiles.push_back(tile);
    std::vector<Searched> found(tiles.size());
    // All tiles that still wait have an equal share of the evaluations.
    const std::int64_t share =
        (options_.max_evaluations - out.evaluations) / std::max<std::int64_t>(waiting(), 1);
    parallel_(int(tiles.size()),
              [&](int n) { found[std::size_t(n)] = search(tiles[std::size_t(n)], share, pass); });
    for (std::size_t n = 0; n < tiles.size(); ++n) {
      stale_[std::size_t(tiles[n])] = found[n].stale;
      out.evaluations += std::max<std::int64_t>(found[n].evaluations, 1);  // a share of none ends, too
    }
    for (std::size_t n = 0; n < tiles.size(); ++n)
      for (const std::uint32_t cell : found[n].changed) note(tiles[n], cell);
  }

  // The tiles whose gains a changed droplet may have altered, but for its own.
  void note(int own, std::uint32_t cell) {
    const int i = int(cell) % setup_.grid.nx, j = int(cell) / setup_.grid.nx;
    for (const int y : {j - kSurroundings, j + kSurroundings})
      for (const int x : {i - kSurroundings, i + kSurroundings}) {
        if (!setup_.grid.contains(x, y)) continue;
        const int tile = y / kTileCells * along_x_ + x / kTileCells;
        Stale& stale = stale_[std::size_t(tile)];
        if (tile != own && stale == kNone) stale = kRim;
      }
  }

  Box box_of(int tile, int around) const {
    const int left = tile % along_x_ * kTileCells, bottom = tile / along_x_ * kTileCells;
    return {std::max(0, left - around), std::max(0, bottom - around),
            std::min(setup_.grid.nx, left + kTileCells + around),
            std::min(setup_.grid.ny, bottom + kTileCells + around)};
  }

  GridSpec grid_of(const Box& b) const {
    GridSpec g = setup_.grid;
    g.nx = b.nx();
    g.ny = b.ny();
    return g;
  }

  template <class Map>
  static Map part_of(const Map& whole, const Box& b, const GridSpec& grid) {
    Map part(grid);
    for (int j = 0; j < b.ny(); ++j)
      std::copy_n(whole.data() + whole.spec.index(b.left, b.bottom + j), b.nx(),
                  part.data() + grid.index(0, j));
    return part;
  }

  void guess(int tile) {
    const Box b = box_of(tile, 0);
    const GridSpec grid = grid_of(b);
    const Mask mask = part_of(setup_.mask, b, grid);
    DropletPattern drops(grid);
    if (options_.start_dithered) {
      Grid<double> wanted(grid), carry(grid);
      for (int j = 0; j < b.ny(); ++j)
        for (int i = 0; i < b.nx(); ++i) {
          const std::size_t c = setup_.grid.index(b.left + i, b.bottom + j);
          const double missing_mm = setup_.target.cells[c] - height_.cells[c];
          wanted.at(i, j) = std::clamp(missing_mm / setup_.model.layer_height_mm(), 0.0, 1.0);
        }
      drops = halftone(wanted, mask, 1, Rounding::kDiffusion, carry);
    } else {
      for (std::size_t c = 0; c < drops.size(); ++c) drops.cells[c] = mask.cells[c] != 0;
    }
    for (int j = 0; j < b.ny(); ++j)
      std::copy_n(drops.data() + grid.index(0, j), b.nx(),
                  drops_.data() + drops_.spec.index(b.left, b.bottom + j));
  }

  Searched search(int tile, std::int64_t evaluations, std::uint32_t pass) {
    const Box own = box_of(tile, 0), seen = box_of(tile, kSurroundings);
    const GridSpec grid = grid_of(seen);
    Setup setup{grid, part_of(setup_.target, seen, grid), part_of(setup_.mask, seen, grid), setup_.model,
                setup_.border};
    const bool whole = stale_[std::size_t(tile)] == kWhole;
    Mask moved(grid);
    bool any = false;
    for (int j = own.bottom; j < own.top; ++j)
      for (int i = own.left; i < own.right; ++i) {
        if (!setup_.mask.at(i, j) || (!whole && depth(own, i, j) >= kRimCells)) continue;
        moved.at(i - seen.left, j - seen.bottom) = 1;
        any = true;
      }
    Searched out;
    if (!any) return out;
    HorizonObjective objective(setup, 1, 1, ErrorKind::kAbsolute, 0.0, 0.0, options_.outside_price);
    objective.move_only(moved);
    objective.set_surface(part_of(height_, seen, grid), 1.0);
    const DropletPattern before = part_of(drops_, seen, grid);
    objective.set_plan(std::vector<DropletPattern>{before});
    RandomStream random(random_bits({setup_.seed, Purpose::kGreedySearch, std::uint32_t(layer_),
                                     std::uint32_t(attempt_), std::uint32_t(tile)}),
                        Purpose::kGreedySearch, pass);
    const SearchResult found = greedy_search(objective, {options_.subset, evaluations}, random);
    out.evaluations = found.evaluations;
    if (!found.optimal) out.stale = whole ? kWhole : kRim;
    const DropletPattern& after = objective.layer(0);
    for (int j = own.bottom; j < own.top; ++j)
      for (int i = own.left; i < own.right; ++i) {
        const std::size_t here = grid.index(i - seen.left, j - seen.bottom);
        if (after.cells[here] == before.cells[here]) continue;
        const std::size_t cell = setup_.grid.index(i, j);
        drops_.cells[cell] = after.cells[here];
        out.changed.push_back(std::uint32_t(cell));
        if (!whole && depth(own, i, j) >= kRimCells - kSurroundings) out.stale = kWhole;
      }
    return out;
  }

  // Cells between a cell and the nearest edge of its tile.
  static int depth(const Box& own, int i, int j) {
    return std::min({i - own.left, own.right - 1 - i, j - own.bottom, own.top - 1 - j});
  }

  std::int64_t part_cells() const {
    return std::ranges::count_if(setup_.mask.cells, [](std::uint8_t in) { return in != 0; });
  }

  const Setup& setup_;
  const HeightMap& height_;
  const MpcOptions& options_;
  int layer_, attempt_;
  const ParallelFor& parallel_;
  int along_x_, along_y_;
  DropletPattern drops_;
  std::vector<Stale> stale_;  // of each tile
};

}  // namespace

TiledLayer tiled_greedy(const Setup& setup, const HeightMap& height, const MpcOptions& options, int layer,
                        int attempt, const ParallelFor& parallel) {
  return Tiles(setup, height, options, layer, attempt, parallel).run();
}

}  // namespace firn::control::mpc
