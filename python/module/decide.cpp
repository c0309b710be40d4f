#include <algorithm>
#include <memory>

#include "config/experiment.h"
#include "core/control/python_scheme.h"
#include "procs/controller/node.h"
#include "python/module/module.h"

namespace firn::python {
namespace {

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t n = 0; n < array.ndim(); ++n) text += (n ? ", " : "") + std::to_string(array.shape(n));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

GridSpec grid_of(const Doubles& map, const std::string& name) {
  if (map.ndim() != 2) throw std::invalid_argument(name + ": shape " + shape_text(map) + " is not (ny, nx)");
  for (int side : {0, 1})
    if (map.shape(side) < 1 || map.shape(side) > kMaxGridSide)
      throw std::invalid_argument(name + ": shape " + shape_text(map) + ": a side has 1 to " +
                                  std::to_string(kMaxGridSide) + " cells");
  GridSpec grid;
  grid.ny = int(map.shape(0));
  grid.nx = int(map.shape(1));
  return grid;
}

template <class Map, class Array>
Map map_of(const Array& array, const GridSpec& grid, const std::string& name) {
  if (array.ndim() != 2 || array.shape(0) != grid.ny || array.shape(1) != grid.nx)
    throw std::invalid_argument(name + ": shape " + shape_text(array) + " is not the grid's (" +
                                std::to_string(grid.ny) + ", " + std::to_string(grid.nx) + ")");
  Map map(grid);
  std::copy_n(array.data(), map.size(), map.data());
  return map;
}

Mask mask_of(const std::optional<Bytes>& array, const GridSpec& grid) {
  if (!array) return Mask(grid, 1);
  Mask mask = map_of<Mask>(*array, grid, "mask");
  const auto wrong = std::ranges::find_if(mask.cells, [](std::uint8_t in) { return in > 1; });
  if (wrong != mask.cells.end())
    throw std::invalid_argument("mask: value " + std::to_string(*wrong) + " is not 0 or 1");
  return mask;
}

const char* word_of(control::Decision::Kind kind) {
  using Kind = control::Decision::Kind;
  return kind == Kind::kPrint ? "print" : kind == Kind::kEnd ? "end" : "stop";
}

}  // namespace

py::dict decide(const Doubles& height_mm, const Doubles& target_mm, const std::optional<Bytes>& mask,
                const std::vector<std::string>& settings, int threads) {
  const GridSpec shape = grid_of(height_mm, "height_mm");
  Experiment e = parse_experiment({}, settings);
  if (control::is_python_scheme(e.control.scheme)) throw NeedsProgram(e.control.scheme);
  e.grid.nx = shape.nx;
  e.grid.ny = shape.ny;
  const HeightMap height = map_of<HeightMap>(height_mm, e.grid, "height_mm");
  HeightMap target = map_of<HeightMap>(target_mm, e.grid, "target_mm");
  Mask part = mask_of(mask, e.grid);
  control::Decision d;
  {
    const py::gil_scoped_release others_go_on;
    const auto scheme =
        make_scheme(control_setup(e, std::move(target), std::move(part)), control_options(e), {});
    scheme->use_threads(parallel_in_c_locale(threads));
    d = scheme->decide({height, 0, 0, 0.0});
  }
  const bool prints = d.kind == control::Decision::Kind::kPrint;
  if (d.drops.size() != height.size()) d.drops = DropletPattern(e.grid);
  using namespace py::literals;
  return py::dict("decision"_a = word_of(d.kind), "reason"_a = d.reason, "droplets"_a = d.drops.total(),
                  "drops"_a = array_of<std::uint8_t>({shape.ny, shape.nx}, d.drops.data()),
                  "objective_mm"_a = prints ? d.objective_mm : d.objective_none_mm,
                  "objective_none_mm"_a = d.objective_none_mm, "iterations"_a = d.iterations);
}

}  // namespace firn::python
