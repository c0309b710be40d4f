// Pictures of a printed block of two inks: cross-sections, the object as it stands when the support is gone,
// the whole block [Lu 2015, Figs. 13-15]. Drawn with a slice as high as a cell is wide; the captions say by
// how much that stretches z.
#pragma once

#include <string>
#include <vector>

#include "report/run/voxels.h"

namespace firn::replay {

/// Object and support in the block's middle along y (x-z) and near its +x side (y-z), one row for each block;
/// what is wrong against `wanted` stands out.
struct NamedBlock {
  std::string name;
  const VoxelBlock* block;
};
std::string section_view(const VoxelBlock& wanted, const std::vector<NamedBlock>& blocks, int section_i,
                         const std::string& title);

struct BlockViewOptions {
  bool support = false;  ///< with the support, opened at the near quarter; else the object alone
};
/// Seen from the +x, -y side, from above; object ink outside M stands out.
std::string block_view(const VoxelBlock& wanted, const VoxelBlock& printed, const BlockViewOptions& options,
                       const std::string& title);

/// z stretched by this much in these pictures.
double z_stretch(const VoxelBlock& block);

}  // namespace firn::replay
