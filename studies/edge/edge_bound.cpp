#include "studies/edge/edge_bound.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "files/command.h"
#include "files/temporary_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr double kUm = 1e3;  // per mm: the solver's tolerances are absolute, of about 1e-7
constexpr const char* kSolver = "cbc";
constexpr const char* kNothingLeaks = "Minimize\n least:\nSubject To\n";

struct Neighbour {
  int di, dj;
  double um;  ///< that a droplet gives it at most
};

std::array<Neighbour, 8> neighbours(const deposition::DropletModel& m) {
  const double side = m.h2_mm * kUm, corner = m.h3_mm * kUm;
  return {{{1, 0, side},
           {-1, 0, side},
           {0, 1, side},
           {0, -1, side},
           {1, 1, corner},
           {-1, 1, corner},
           {1, -1, corner},
           {-1, -1, corner}}};
}

double part_mm(const HeightMap& target, const Mask& mask) {
  double sum = 0.0;
  for (std::size_t c = 0; c < mask.size(); ++c)
    if (mask.cells[c]) sum += target.cells[c];
  return sum;
}

}  // namespace

std::string edge_programme(const HeightMap& target, const Mask& mask, const deposition::DropletModel& model,
                           deposition::Border border, double mean_abs_mm) {
  if (target.spec != mask.spec || target.size() != mask.size())
    throw std::invalid_argument("edge_bound: target and mask differ in size");
  if (!(mean_abs_mm >= 0.0) || !std::isfinite(mean_abs_mm))
    throw std::invalid_argument(fmt::format("edge_bound: mean error = {} mm must be 0 or more", mean_abs_mm));
  if (!(part_mm(target, mask) > 0.0)) throw std::invalid_argument("edge_bound: the part has no volume");
  const GridSpec& g = mask.spec;
  const auto around = neighbours(model);
  // Rows of cells are written as they come: gifts from before a cell and to after it are named by both.
  std::string least, rows, limits, errors;
  const auto out = [](std::string& text) { return std::back_inserter(text); };
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      if (!mask.at(i, j)) continue;
      const std::size_t c = g.index(i, j);
      double kept_um = model.h1_mm * kUm, leak_um = 0.0;
      std::string gifts;
      for (const auto& [di, dj, um] : around) {
        const bool on_grid = g.contains(i + di, j + dj);
        if (!on_grid && border == deposition::Border::kKeep) {
          kept_um += um;
          continue;
        }
        if (!on_grid || !mask.at(i + di, j + dj)) {
          leak_um += um;
          continue;
        }
        kept_um += um;
        const std::size_t t = g.index(i + di, j + dj);
        fmt::format_to(out(gifts), " - g{}_{} + g{}_{}", c, t, t, c);
        fmt::format_to(out(limits), " g{}_{} - {} n{} <= 0\n", c, t, um, c);
      }
      if (leak_um > 0.0) fmt::format_to(out(least), " + {} n{}\n", leak_um, c);
      fmt::format_to(out(rows), " {} n{}{} + p{} - m{} = {}\n", kept_um, c, gifts, c, c,
                     target.at(i, j) * kUm);
      fmt::format_to(out(errors), " + p{} + m{}\n", c, c);
    }
  return "Minimize\n least:\n" + least + "Subject To\n" + rows + limits + " error:\n" + errors +
         fmt::format(" <= {}\nEnd\n", mean_abs_mm * kUm * double(mask.count()));
}

bool has_edge_solver() { return !run_command({kSolver, "-quit"}).missing(); }

double edge_bound(const HeightMap& target, const Mask& mask, const deposition::DropletModel& model,
                  deposition::Border border, double mean_abs_mm) {
  const std::string programme = edge_programme(target, mask, model, border, mean_abs_mm);
  if (programme.starts_with(kNothingLeaks)) return 0.0;
  const TemporaryFolder folder("edge");
  const fs::path file = folder / "edge.lp", answer = folder / "edge.txt";
  std::ofstream(file) << programme;
  const CommandEnd end = run_command({kSolver, file.string(), "-solve", "-solu", answer.string()});
  if (end.missing())
    throw std::runtime_error("cbc is not installed, which the bound needs: apt-get install coinor-cbc");
  std::ifstream in(answer);
  std::string optimal, dash, objective, value;
  double least_um = 0.0;
  in >> optimal >> dash >> objective >> value >> least_um;
  if (end.code != 0 || !in || optimal != "Optimal")
    throw std::runtime_error(fmt::format("cbc found no optimum: exit code {}, \"{}\"", end.code, optimal));
  return least_um / (part_mm(target, mask) * kUm);
}

}  // namespace firn
