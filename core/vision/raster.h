// Raster applies OpenCV to masks: labels, holes, distances, moments, dilation. All of it is in whole numbers
// (squared distances are rounded again), so that neither threads nor vector units change a byte. Own code
// remains where OpenCV is coarser than the measurement: cv::remap and warpAffine round places to 1/32 px,
// INTER_AREA rounds means to grey levels, fitEllipse has no weights, and none of them leaves out what is not
// measured.
#pragma once

#include <cstdint>
#include <vector>

#include "core/vision/bulges.h"

namespace firn::vision {

/// A mask row by row; 0 is off.
struct CellMask {
  int columns = 0, rows = 0;
  std::vector<std::uint8_t> cells;

  CellMask(int c, int r) : columns(c), rows(r), cells(std::size_t(c) * std::size_t(r)) {}
  std::size_t index(int i, int j) const { return std::size_t(j) * std::size_t(columns) + std::size_t(i); }
};

/// Connected cells (8 neighbours) of a mask: `box[n]` bounds the cells whose label is n + 1; 0 is off.
struct Labels {
  struct Box {
    int x0 = 0, y0 = 0, columns = 0, rows = 0;
    long cells = 0;
  };
  std::vector<int> label;
  std::vector<Box> box;
};
Labels label_cells(const CellMask& mask);

/// The components of a mask whose first cell is the pixel (x0, y0), in any order; `at_edge` is false.
std::vector<Component> components_of(const CellMask& mask, int x0, int y0);

/// Switches on the cells that are off and not connected (4 neighbours) to the mask's surroundings.
void fill_holes(Silhouette& silhouette);

/// Squared distance of each cell to the nearest cell off the mask. Beyond the lattice lies ground, beyond the
/// picture's edge nothing; 2^30 where there is no ground at all.
std::vector<int> squared_distances(const Silhouette& silhouette);

/// Sums over the cells of a mask that are connected (4 neighbours) to one of them.
struct CellSums {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  bool left = false, top = false, right = false, bottom = false;  ///< reaches this side of the mask
};
CellSums connected_sums(CellMask& mask, int i, int j);

/// Adds the cells within 3 cells of the mask, in an octagon.
CellMask dilated(const CellMask& mask);

/// White minus the picture, at least 0.
Frame inverted_frame(const Frame& frame);

}  // namespace firn::vision
