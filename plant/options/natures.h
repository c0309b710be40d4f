// The names of the physics that a simulated ink-jet lab can have, and the parameters of each.
#pragma once

#include <string_view>

#include "plant/options/faults.h"
#include "plant/options/graph_flow.h"
#include "plant/options/thin_film.h"
#include "plant/options/wu_chiu.h"

namespace firn::plant {

/// A word of plant.model. Its physics is a row of kNatures (plant/inkjet/model.cpp).
struct NatureName {
  std::string_view name, meaning;
  bool between_cells;  ///< a droplet beside a cell's middle lands there, and not in the middle
  bool two_inks;
};
inline constexpr NatureName kNatureNames[] = {
    {"droplets", "Firn's own physics: droplets as volumes on a field of fine cells", true, true},
    {"lu2015", "the simulation of [Lu 2015, V-A]", false, true},
    {"wu_chiu", "volume and area of each cell, droplet by droplet, after Wu and Chiu", false, false},
    {"graph_flow", "wet ink that flows along the edges of a graph of cells, after Guo et al.", false, false},
    {"thin_film", "wet ink that flows as a thin film by lubrication theory", true, false},
};

/// Returns the row of a name; nullptr: there is none (a class in Python has none).
constexpr const NatureName* nature_name(std::string_view name) {
  for (const NatureName& n : kNatureNames)
    if (n.name == name) return &n;
  return nullptr;
}

/// Parameters of the physics that have some of their own, "plant.NAME.OPTION".
struct NatureOptions {
  WuChiuOptions wu_chiu;
  GraphFlowOptions graph_flow;
  ThinFilmOptions thin_film;
  bool operator==(const NatureOptions&) const = default;
};

/// Calls f(name, options, table) for each physics with parameters of its own.
template <class Options, class F>
void for_each_nature(Options& options, F&& f) {
  f(std::string_view("wu_chiu"), options.wu_chiu, kWuChiuOptions);
  f(std::string_view("graph_flow"), options.graph_flow, kGraphFlowOptions);
  f(std::string_view("thin_film"), options.thin_film, kThinFilmOptions);
}

/// Faults of the lab's instruments.
struct FaultOptions {
  SensorOptions sensor;
  NozzleFaults nozzle;
  StageFaults stage;
  bool operator==(const FaultOptions&) const = default;
};

}  // namespace firn::plant
