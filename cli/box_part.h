// The part of [Barnett 2012, Figs. 4-15, 5-10] as a mesh, and a caliper on its simulated surface.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "cli/sample_mesh.h"
#include "core/grid/grid.h"

namespace firn::barnett {

/// A box on a plate. Its outline is that of Fig. 4-2: 92 mm, rounds of 20 and 10 mm and one sharp corner. The text gives
/// neither drawing nor meaning of l1..l7, only their nominal values (Table 5-1); this reading has them all, and all
/// outside dimensions, as 5.3 says of the caliper: l1 the box's wall, l2 the plate's thickness, l3 the diagonal from the sharp corner
/// (to a round of 16 mm: 123.48 mm), l4 the plate, l5 and l7 the box, l6 its height.
struct BoxPart {
  double wall_mm = 6.0;      ///< l1
  double plate_mm = 6.0;     ///< l2
  double ledge_mm = 12.0;    ///< of the plate around the box: l4 = l5 + 2 ledge
  double side_mm = 92.0;     ///< l5, l7
  double height_mm = 25.0;   ///< l6
  std::array<double, 4> round_mm{0.0, 20.0, 16.0, 10.0};  ///< of the corners (-x-y), (+x-y), (+x+y), (-x+y)
  int round_edges = 16;        ///< edges of each round in the mesh
  double diagonal_mm() const;  ///< l3
};

/// Middle of the box at x = y = 0, plate on z = 0. @param plate_on_top upside down
SampleMesh mesh_of(const BoxPart& part, bool plate_on_top = false);

/// One dimension at several places.
struct Dimension {
  std::string name, what;
  double nominal_mm = 0.0;
  std::vector<double> measured_mm;
};

/// As with a caliper whose jaws are `jaw_mm` wide and touch the outermost of the roughness [5.3], each at four places.
/// @param ice thickness of the ice over fine cells, the middle of the box at x = y = 0
std::vector<Dimension> measured(const BoxPart& part, const HeightMap& ice, double jaw_mm = 3.0);

}  // namespace firn::barnett
