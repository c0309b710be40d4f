// mesh_of computes the part of [Barnett 2012, Figs. 4-15, 5-10] as a mesh; measured() simulates a caliper on
// its printed surface.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/grid/grid.h"
#include "files/mesh/sample_mesh.h"

namespace firn::barnett {

/// Holds a box on a plate. Its outline is that of Fig. 4-2: 92 mm, rounds of 20 and 10 mm and one sharp
/// corner. The text gives neither drawing nor meaning of l1..l7, only their nominal values (Table 5-1). This
/// reading has all of l1..l7, and all outside dimensions, as 5.3 says of the caliper: l1 the box's wall, l2
/// the plate's thickness, l3 the diagonal from the sharp corner (to a round of 16 mm: 123.48 mm), l4 the
/// plate, l5 and l7 the box, l6 its height.
struct BoxPart {
  double wall_mm = 6.0;                                   ///< l1
  double plate_mm = 6.0;                                  ///< l2
  double ledge_mm = 12.0;                                 ///< of the plate around the box: l4 = l5 + 2 ledge
  double side_mm = 92.0;                                  ///< l5, l7
  double height_mm = 25.0;                                ///< l6
  std::array<double, 4> round_mm{0.0, 20.0, 16.0, 10.0};  ///< of the corners (-x-y), (+x-y), (+x+y), (-x+y)
  int round_edges = 16;                                   ///< edges of each round in the mesh
  double diagonal_mm() const;                             ///< l3
};

/// Returns the mesh with the middle of the box at x = y = 0, plate on z = 0. @param plate_on_top upside down
SampleMesh mesh_of(const BoxPart& part, bool plate_on_top = false);

/// Holds one dimension at several places.
struct Dimension {
  std::string name, what;
  double nominal_mm = 0.0;
  std::vector<double> measured_mm;
};

/// "The caliper measures to the outer edge of the roughness" and "crushes the sharp edge slightly" [5.3]: a
/// jaw comes to rest where it touches over `crush_mm` of its width.
struct Caliper {
  double jaw_mm = 3.0, crush_mm = 1.0;
};

/// Holds the ice of the wall between two heights.
struct WallBand {
  double height_mm = 0.0;  ///< of the band
  HeightMap ice;           ///< thickness in it
};

/// Measures each dimension at four places, l3 once in each band. Cells at a wall's edge hold ice of as many
/// of their layers as reach so far: their thickness is a share of layers and not a height, and the edge is
/// the place that half of these layers reach. (So four levels of one map are no four heights.)
/// @param ice thickness of all ice over fine cells, the middle of the box at x = y = 0
/// @param bands of the wall, above each other; empty: l3 is measured once, over all of the wall
std::vector<Dimension> measured(const BoxPart& part, const HeightMap& ice, std::span<const WallBand> bands,
                                const Caliper& caliper = {});

}  // namespace firn::barnett
