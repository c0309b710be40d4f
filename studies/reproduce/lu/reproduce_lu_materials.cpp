// Computes [Lu 2015, V-A, Figs. 13-15]: the junction of two pipes, printed of object ink in a block of
// support, open loop against closed loop. The paper shows pictures and prints no numbers; Firn counts the
// voxels of the wrong ink.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "report/draw/svg.h"
#include "report/run/block_view.h"
#include "report/run/voxels.h"
#include "runtime/source_folder.h"
#include "studies/reproduce/reproduce_parts.h"

namespace firn {
namespace {

constexpr int kMaterialsSeeds = 20, kMaterialsSeedsQuick = 2;
constexpr int kPlantSeeds = 3, kPlantSeedsQuick = 1;  // on Firn's own plant, which takes longer
constexpr const char* kId = "lu.figs-13-15.";

struct JunctionOutcome {
  report::WrongVoxels wrong;
  report::Washed washed;
  ErrorStats top;                      ///< of the block's surface about h_d
  report::VoxelBlock printed, wanted;  ///< of the first seed
};

struct Case {
  Experiment experiment;
  Blobs inputs;
  Geometry geometry;
  double slice_mm;
};

Case load_case() {
  const std::filesystem::path file = source_folder() / "experiments" / "pipe-junction.toml";
  const Experiment e = load_experiment(file);
  const Blobs in = make_inputs(full_product(), e, file.parent_path());
  return {e, in, geometry_from_bytes(blob(in, "geometry").bytes, e.grid, "geometry"),
          e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm};
}

JunctionOutcome print(const Case& c, const std::string& plant, const std::string& scheme, int seed) {
  Experiment e = c.experiment;
  e.plant.model = plant;
  e.control.scheme = scheme;
  e.plant.seed = std::uint64_t(seed);
  MemoryPrintOptions options;
  options.surface = options.materials = true;
  const MemoryPrintReport report = print_in_memory(full_product(), e, c.inputs, options);
  if (runs::can_go_on(report.result))
    throw std::runtime_error("the " + scheme + " print of seed " + std::to_string(seed) +
                             " did not finish: " + report.result.reason);
  JunctionOutcome o;
  const int nz = report::slices_for(report.materials, c.geometry, c.slice_mm);
  o.printed = report::voxels_of(report.materials, c.slice_mm, nz);
  o.wanted = report::voxels_of(c.geometry, c.slice_mm, nz);
  o.wrong = report::count_wrong(o.wanted, o.printed);
  o.washed = report::wash(o.printed);
  o.top = report.error;
  if (seed != 1) o.printed = o.wanted = {};
  return o;
}

// Makes all prints on the given number of threads; the order of the result does not depend on it.
std::vector<JunctionOutcome> print_all(const Case& c, const std::string& plant, int seeds, Reproduction& to) {
  const std::string schemes[] = {"open_loop", "mpc"};
  std::vector<JunctionOutcome> out(2 * std::size_t(seeds));
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  std::mutex lock;
  std::exception_ptr failure;
  const auto work = [&] {
    for (std::size_t n; (n = next++) < out.size();) {
      try {
        out[n] = print(c, plant, schemes[n / std::size_t(seeds)], int(n % std::size_t(seeds)) + 1);
      } catch (...) {
        const std::lock_guard hold(lock);
        failure = std::current_exception();
        return;
      }
      const std::lock_guard hold(lock);
      to.progress(double(++done) / double(out.size()), "pipe junction on the plant " + plant);
    }
  };
  std::vector<std::jthread> threads;
  for (int t = 1; t < to.threads(); ++t) threads.emplace_back(work);
  work();
  threads.clear();
  if (failure) std::rethrow_exception(failure);
  return out;
}

template <class Value>
double mean(std::span<const JunctionOutcome> runs, const Value& value) {
  double sum = 0.0;
  for (const JunctionOutcome& o : runs) sum += double(value(o));
  return sum / double(runs.size());
}

// Returns the maximum closed / open of any seed (the same seed: common random numbers).
template <class Value>
double worst_share(std::span<const JunctionOutcome> open, std::span<const JunctionOutcome> closed,
                   const Value& value) {
  double worst = 0.0;
  for (std::size_t n = 0; n < open.size(); ++n) {
    const double a = double(value(closed[n])), b = double(value(open[n]));
    worst = std::max(worst, b > 0.0 ? a / b : a > 0.0 ? HUGE_VAL : 0.0);
  }
  return worst;
}

constexpr const char* kPlace = "p. 1064, V-A, Figs. 13, 14";

// Wrong voxels of one kind: means of both loops, the largest share of any seed.
struct WrongShare {
  std::string words;
  bool halved = false;
};
template <class Value>
WrongShare wrong_share(const std::string& where, std::span<const JunctionOutcome> open,
                       std::span<const JunctionOutcome> closed, const Value& value) {
  const double a = mean(open, value), b = mean(closed, value);
  return {
      fmt::format("{} {:.1f} of {:.1f} (worst seed {:.2f})", where, b, a, worst_share(open, closed, value)),
      b <= 0.5 * a};
}

void count_rows(std::span<const JunctionOutcome> open, std::span<const JunctionOutcome> closed,
                Reproduction& to) {
  const WrongShare shares[] = {
      wrong_share("inside M", open, closed, [](const JunctionOutcome& o) { return o.wrong.inside; }),
      wrong_share("outside", open, closed, [](const JunctionOutcome& o) { return o.wrong.outside; }),
      wrong_share("boundary layer", open, closed,
                  [](const JunctionOutcome& o) { return o.wrong.boundary_wrong(); })};
  to.row(
      ReproduceRow(kId + std::string("wrong"), "Wrong voxels in closed loop, of those in open loop", "",
                   fmt::format("{}; {}; {}", shares[0].words, shares[1].words, shares[2].words))
          .prints(
              "no visible deformation", kPlace,
              "the printed object can accurately represent the desired geometry with no visible deformation")
          .holds(std::ranges::all_of(shares, &WrongShare::halved), "each at most half of open loop's"));
  const auto std_um = [](const JunctionOutcome& o) { return o.top.std_mm * 1e3; };
  to.row(ReproduceRow(kId + std::string("top-surface"),
                      "Deviation of the block's top: closed loop, at most half of open loop's " +
                          report::number(mean(open, std_um), 1) + " um",
                      "um", mean(closed, std_um))
             .prints("top surface is almost flat", kPlace, "The top surface is almost flat")
             .at_most(0.5 * mean(open, std_um)));
}

void wash_rows(std::span<const JunctionOutcome> closed, Reproduction& to) {
  const double loose = mean(closed, [](const JunctionOutcome& o) {
    return 100.0 * double(o.washed.object - o.washed.largest_piece) / double(o.washed.object);
  });
  const double shut = mean(closed, [](const JunctionOutcome& o) {
    return 100.0 * double(o.washed.support_shut_in) / double(o.washed.support);
  });
  constexpr const char* kFig15 = "p. 1065, Fig. 15";
  constexpr const char* kWords =
      "sacrificial material should be washed away/removed and the object part is then obtained";
  to.row(ReproduceRow(kId + std::string("one-piece"),
                      "Object ink that is not part of the one piece left (closed loop)", "%", loose)
             .prints("the object part is then obtained", kFig15, kWords)
             .at_most(0.1));
  to.row(ReproduceRow(kId + std::string("washed-away"), "Support that washing cannot reach (closed loop)",
                      "%", shut)
             .prints("sacrificial material should be washed away", kFig15, kWords)
             .at_most(0.1));
}

// The same on the independent plant, which knows nothing of (7).
void own_plant_rows(const Case& c, Reproduction& to) {
  const int seeds = to.quick() ? kPlantSeedsQuick : kPlantSeeds;
  const std::vector<JunctionOutcome> all = print_all(c, "droplets", seeds, to);
  const std::span<const JunctionOutcome> open(all.data(), std::size_t(seeds)),
      closed(all.data() + seeds, std::size_t(seeds));
  const auto beside = [&](const char* name, const char* where, auto value) {
    to.beside(
        {kId + std::string(name),
         fmt::format("Firn's own plant, {} seeds: wrong voxels in closed loop, of those in open loop", seeds),
         "", wrong_share(where, open, closed, value).words});
  };
  beside("own-plant", "inside and outside M", [](const JunctionOutcome& o) { return o.wrong.wrong(); });
  beside("own-plant-boundary", "boundary layer",
         [](const JunctionOutcome& o) { return o.wrong.boundary_wrong(); });
}

void pictures(const JunctionOutcome& open, const JunctionOutcome& closed, Reproduction& to) {
  const std::string stretch =
      " z is drawn " + report::number(report::z_stretch(open.wanted), 0) + " times as high.";
  const report::VoxelBlock& tall = open.wanted.nz > closed.wanted.nz ? open.wanted : closed.wanted;
  const int section_i = int(0.85 * tall.grid.nx);
  to.picture({"fig-13-open-loop", "Fig. 13: open loop, the object after washing, seed 1." + stretch,
              report::block_view(open.wanted, open.printed, {}, "Pipe junction printed in open loop")});
  to.picture({"fig-14-closed-loop", "Fig. 14: closed loop, the object after washing, seed 1." + stretch,
              report::block_view(closed.wanted, closed.printed, {}, "Pipe junction printed in closed loop")});
  to.picture(
      {"fig-15-block",
       "Fig. 15: the whole block as printed in closed loop, its support opened at one quarter." + stretch,
       report::block_view(closed.wanted, closed.printed, {true}, "Pipe junction in its support")});
  to.picture({"figs-13-14-sections",
              "Cross-sections of Figs. 13 and 14: as wanted, open loop, closed loop, seed 1." + stretch,
              report::section_view(
                  tall, {{"wanted", &tall}, {"open loop", &open.printed}, {"closed loop", &closed.printed}},
                  section_i, "Cross-sections of the pipe junction")});
}

}  // namespace

void reproduce_lu_materials(Reproduction& to) {
  const Case c = load_case();
  const int seeds = to.quick() ? kMaterialsSeedsQuick : kMaterialsSeeds;
  to.note(
      "Figs. 13-15 print no sizes and no numbers: geometry, g1..g3, alpha and h_d are chosen and stated in "
      "experiments/pipe-junction.toml. Each print is one of the whole lab with two jets, in simulated time; "
      "its plant is the paper's simulation (7) with 20 % variation; open loop takes each "
      "layer's inks from layers of fixed height, closed loop is (8) with the inks of the measured heights. "
      "Voxels are a "
      "cell wide and a nominal layer high and are counted in the plant's truth; means of " +
      std::to_string(seeds) + " seeds.");
  const std::vector<JunctionOutcome> all = print_all(c, "lu2015", seeds, to);
  const std::span<const JunctionOutcome> open(all.data(), std::size_t(seeds)),
      closed(all.data() + seeds, std::size_t(seeds));
  count_rows(open, closed, to);
  wash_rows(closed, to);
  own_plant_rows(c, to);
  pictures(open[0], closed[0], to);
}

}  // namespace firn
