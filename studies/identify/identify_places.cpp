#include "studies/identify/identify_places.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace firn {

bool prints_places(const Experiment& e) {
  return e.actuation.offsets != OffsetKind::kNone && e.control.scheme == "pattern" &&
         e.control.pattern.kind == control::PatternKind::kPlaces;
}

PlaceIdentification identify_places(const ObservedRun& run, OffsetKind kind) {
  const Experiment& e = run.experiment();
  PlaceIdentification id;
  id.options = e.actuation;
  id.printed = OffsetTable(id.options);
  id.options.offsets = kind;
  id.table = OffsetTable(id.options);
  id.layers = run.layers();
  if (id.printed.size() == 1) {
    id.uninformative = "actuation.offsets is none: all droplets are in the centres";
    return id;
  }
  id.prints = droplet::find_place_prints(run.printed(), run.offsets(), id.printed, id.table);
  id.uninformative = id.prints.missing;
  if (!id.uninformative.empty()) return id;
  const deposition::DropletModel model{e.model.h1_mm, e.model.h2_mm, e.model.h3_mm};
  id.mixed_error.resize(id.prints.kernels.size());
  for (int n = 1; n < id.table.size(); ++n) {
    deposition::OffsetKernel mixed = mixed_kernel(model, id.table[n]);
    for (double& h : mixed.height_mm) h *= id.table.share(n);
    for (std::size_t k = 0; k < mixed.height_mm.size(); ++k)
      id.mixed_error[std::size_t(n)] =
          std::max(id.mixed_error[std::size_t(n)],
                   std::abs(id.prints.kernels[std::size_t(n)].height_mm[k] - mixed.height_mm[k]) /
                       id.prints.drop_height_mm);
  }
  return id;
}

std::string places_toml(const PlaceIdentification& id) {
  std::string text = fmt::format("[actuation]\noffsets = \"{}\"\npositions_x = {}\npositions_y = {}\n",
                                 word(id.options.offsets), id.options.positions_x, id.options.positions_y);
  if (id.prints.small_drop_height_mm > 0.0)
    text += fmt::format("small_share = {:.4f}\n", id.prints.small_drop_height_mm / id.prints.drop_height_mm);
  text += "heights_mm = [\n";
  for (int n = 1; n < id.table.size(); ++n) {
    text += fmt::format("  # place {} at ({:.4f}, {:.4f}) of the pitch{}\n", n, id.table[n].x, id.table[n].y,
                        id.table.small(n) ? ", small droplets" : "");
    for (int y = -2; y <= 2; ++y) {
      text += " ";
      for (int x = -2; x <= 2; ++x)
        text += fmt::format(" {:.7f},", id.prints.kernels[std::size_t(n)].at(x, y));
      text += "\n";
    }
  }
  return text + "]\n";
}

}  // namespace firn
