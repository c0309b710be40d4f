// Draws pictures of a printed block of two inks: cross-sections, the object after the support is removed, the
// whole block [Lu 2015, Figs. 13-15]. Slices are drawn as high as a cell is wide; the captions state the
// stretch of z.
#pragma once

#include <string>
#include <vector>

#include "report/run/voxels.h"

namespace firn::report {

/// Names a block of section_view. The sections show object and support in the block's middle along y (x-z)
/// and near its +x side (y-z), one row for each block; voxels that differ from `wanted` are highlighted.
struct NamedBlock {
  std::string name;
  const VoxelBlock* block;
};
std::string section_view(const VoxelBlock& wanted, const std::vector<NamedBlock>& blocks, int section_i,
                         const std::string& title);

struct BlockViewOptions {
  bool support = false;  ///< with the support, opened at the near quarter; else the object alone
};
/// Draws the block seen from the +x, -y side, from above; object ink outside M is highlighted.
std::string block_view(const VoxelBlock& wanted, const VoxelBlock& printed, const BlockViewOptions& options,
                       const std::string& title);

/// Returns the stretch of z in these pictures.
double z_stretch(const VoxelBlock& block);

}  // namespace firn::report
