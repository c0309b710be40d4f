#include "studies/reproduce/lu/lu_prints.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

#include "config/include.h"
#include "print/inputs/targets.h"
#include "print/labs/full_product.h"
#include "runtime/source_folder.h"

namespace firn {

Experiment lu_lab(const std::string& shape, double cells_across, double height_mm) {
  Experiment e = load_experiment(source_folder() / "labs" / "inkjet-lu2015.toml");
  e.part.shape.kind = shape;
  // Half a cell less than the outer centres' distance plus one: exactly so many centres lie inside.
  const double across_mm = (cells_across - (shape == "cuboid" ? 0.5 : 0.0)) * e.grid.pitch_x_mm;
  e.part.shape.diameter_mm = e.part.shape.width_mm = e.part.shape.depth_mm = across_mm;
  e.part.shape.height_mm = height_mm;
  e.plant.dropout_fraction = 0.0;
  return e;
}

Target lu_target(const Experiment& e) { return make_shape(e.part.shape, e.grid); }

std::vector<MemoryPrintReport> print_seeds(const Experiment& experiment, int seeds, Reproduction& to,
                                           double from, double to_fraction, const std::string& doing) {
  const Blobs inputs = make_inputs(full_product(), experiment, ".");
  std::vector<MemoryPrintReport> prints(std::size_t(seeds), MemoryPrintReport{});
  std::atomic<int> next{0};
  int done = 0;
  std::mutex lock;
  std::exception_ptr failure;
  const auto work = [&] {
    for (int n; (n = next++) < seeds;) try {
        Experiment e = experiment;
        e.plant.seed = std::uint64_t(n + 1);
        prints[std::size_t(n)] =
            print_in_memory(full_product(), e, inputs, {.series = true, .surface = true, .outline = true});
        const std::lock_guard hold(lock);
        to.progress(from + (to_fraction - from) * ++done / seeds, doing);
      } catch (...) {
        const std::lock_guard hold(lock);
        failure = std::current_exception();
        return;
      }
  };
  std::vector<std::jthread> threads;
  for (int t = 1; t < std::min(to.threads(), seeds); ++t) threads.emplace_back(work);
  work();
  threads.clear();
  if (failure) std::rethrow_exception(failure);
  return prints;
}

double mean_of(const std::vector<MemoryPrintReport>& prints,
               const std::function<double(const MemoryPrintReport&)>& value) {
  double sum = 0.0;
  for (const MemoryPrintReport& p : prints) sum += value(p);
  return sum / double(prints.size());
}

double largest_of(const std::vector<MemoryPrintReport>& prints,
                  const std::function<double(const MemoryPrintReport&)>& value) {
  double largest = -std::numeric_limits<double>::infinity();
  for (const MemoryPrintReport& p : prints) largest = std::max(largest, value(p));
  return largest;
}

HeightProfile middle_row(const HeightMap& height, const GridSpec& grid) {
  HeightProfile p;
  for (int i = 0; i < grid.nx; ++i) {
    p.x_mm.push_back(i * grid.pitch_x_mm);
    p.height_um.push_back(1e3 * height.at(i, grid.ny / 2));
  }
  return p;
}

}  // namespace firn
