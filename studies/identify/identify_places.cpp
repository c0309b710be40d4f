#include "studies/identify/identify_places.h"

#include <fmt/core.h>

namespace firn {

bool prints_places(const Experiment& e) {
  return e.actuation.offsets != OffsetKind::kNone && e.control.scheme == "pattern" &&
         e.control.pattern.kind == control::PatternKind::kPlaces;
}

PlaceIdentification identify_places(const ObservedRun& run) {
  PlaceIdentification id;
  id.options = run.experiment().actuation;
  id.table = OffsetTable(id.options);
  id.layers = run.layers();
  id.prints = droplet::find_place_prints(run.printed(), run.offsets(), id.table);
  if (id.table.size() == 1) {
    id.uninformative = "actuation.offsets is none: all droplets are in the centres";
  } else if (!id.prints.complete()) {
    for (int n = 0; n < id.table.size() && id.uninformative.empty(); ++n)
      if (const int found = id.prints.places[std::size_t(n)].own.n; found < 2)
        id.uninformative = fmt::format(
            "{} droplets alone at place {}, two at least are needed: print experiments/places.toml", found,
            n);
  } else if (!(id.prints.drop_height.mean_mm > id.prints.drop_height.half_width_mm)) {
    id.uninformative = "the maps do not rise under the droplets";
  }
  return id;
}

std::string places_toml(const PlaceIdentification& id) {
  const deposition::DropletModel& h = id.prints.centre;
  std::string text =
      fmt::format("[model]\nh1_mm = {:.7f}\nh2_mm = {:.7f}\nh3_mm = {:.7f}\n\n", h.h1_mm, h.h2_mm, h.h3_mm);
  text += fmt::format("[actuation]\noffsets = \"{}\"\npositions_x = {}\npositions_y = {}\nheights_mm = [\n",
                      word(id.options.offsets), id.options.positions_x, id.options.positions_y);
  for (int n = 1; n < id.table.size(); ++n) {
    text += fmt::format("  # place {} at ({:.4f}, {:.4f}) of the pitch\n", n, id.table[n].x, id.table[n].y);
    for (int y = -2; y <= 2; ++y) {
      text += " ";
      for (int x = -2; x <= 2; ++x)
        text += fmt::format(" {:.7f},", id.prints.places[std::size_t(n)].kernel.at(x, y));
      text += "\n";
    }
  }
  return text + "]\n";
}

}  // namespace firn
