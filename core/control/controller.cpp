#include "core/control/controller.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/options/range.h"

namespace firn::control {
namespace {

std::string cell_name(const GridSpec& g, std::size_t c) {
  return "cell (" + std::to_string(c % std::size_t(g.nx)) + ", " + std::to_string(c / std::size_t(g.nx)) +
         ")";
}

}  // namespace

void check(const Setup& s) {
  firn::check(s.grid);
  deposition::check(s.model);
  if (s.target.size() != s.grid.size() || s.mask.size() != s.grid.size())
    throw std::invalid_argument("controller: target (" + std::to_string(s.target.size()) +
                                " cells) and mask (" + std::to_string(s.mask.size()) +
                                ") must have the grid's " + std::to_string(s.grid.size()));
  std::size_t cells = 0;
  for (std::size_t c = 0; c < s.mask.size(); ++c) {
    if (!s.mask.cells[c]) continue;
    ++cells;
    if (!(std::isfinite(s.target.cells[c]) && s.target.cells[c] >= 0.0))
      throw std::invalid_argument("controller: target of " + cell_name(s.grid, c) +
                                  " is not a height of 0 mm or more");
  }
  if (cells == 0) throw std::invalid_argument("controller: the mask has no cell");
  if (s.rim.size() != 0) {
    deposition::check(s.model_b);
    if (s.geometry)
      throw std::invalid_argument("controller: a rim of its own model is known with one ink only");
    if (s.rim.size() != s.grid.size())
      throw std::invalid_argument("controller: the rim (" + std::to_string(s.rim.size()) +
                                  " cells) must have the grid's " + std::to_string(s.grid.size()));
  }
  if (!s.geometry) return;
  deposition::check(s.model_b);
  if (s.geometry->grid() != s.grid) throw std::invalid_argument("controller: the geometry has another grid");
  if (!(std::isfinite(s.judge_above_mm) && s.judge_above_mm >= 0.0))
    throw std::invalid_argument("controller: judge_above_mm = " + shortest_text(s.judge_above_mm) +
                                " must not be below 0");
}

void check(const Measurement& m, const Setup& s) {
  if (m.height.spec != s.grid || m.height.size() != s.grid.size())
    throw std::invalid_argument("height map: its grid (" + std::to_string(m.height.spec.nx) + " x " +
                                std::to_string(m.height.spec.ny) + ") is not the controller's (" +
                                std::to_string(s.grid.nx) + " x " + std::to_string(s.grid.ny) +
                                ", same origin and pitch)");
  if (m.layer < 0 || m.attempt < 0)
    throw std::invalid_argument("height map: layer " + std::to_string(m.layer) + ", attempt " +
                                std::to_string(m.attempt) + ": neither may be below 0");
  for (std::size_t c = 0; c < m.height.size(); ++c)
    if (s.mask.cells[c] && !std::isfinite(m.height.cells[c]))
      throw std::invalid_argument("height map: " + cell_name(s.grid, c) +
                                  " of the part has no finite height");
}

HeightMap known_heights(const Measurement& m) {
  HeightMap h = m.height;
  for (double& v : h.cells)
    if (!std::isfinite(v)) v = 0.0;
  return h;
}

MaterialMap materials_at(const Setup& s, const HeightMap& height, double rise_mm) {
  if (!s.geometry) return {};
  MaterialMap inks(s.grid);
  for (std::size_t c = 0; c < inks.size(); ++c)
    if (s.mask.cells[c]) inks.set(c, s.geometry->at(c, height.cells[c] + (rise_mm + s.judge_above_mm)));
  return inks;
}

MaterialMap materials_at(const Setup& s, double height_mm) {
  return materials_at(s, HeightMap(s.grid, height_mm));
}

}  // namespace firn::control
