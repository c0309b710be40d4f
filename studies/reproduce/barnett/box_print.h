// print_box prints the part of Fig. 4-15 [Barnett 2012, 5.3] under feedback in the simulated ice lab, in
// memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "files/temporary_folder.h"
#include "print/simulated/memory_print.h"
#include "studies/reproduce/barnett/box_part.h"

namespace firn::barnett {

inline constexpr const char* kBoxMachine = "[machine]\nname = \"cobra600\"\n";
inline constexpr double kBoxLayer_mm = 0.25;

/// Holds the files that the lab's own code reads (box.stl, slice.toml, machine.toml) during its lifetime.
/// @throws UsageError: no folder can be made
class BoxFolder {
 public:
  BoxFolder(const BoxPart& part, bool plate_on_top);

 private:
  TemporaryFolder folder_;

 public:
  std::filesystem::path path;
};

/// Plate below, 5 x 0.25 mm to an interval, SMF by valve frequency with the optimal gains: "SMF, MTTS and
/// VFVC all online" (5.3). Its slicing offsets and the spacing of its measurement were chosen on seed 1.
/// @param layer called after every measured layer; may be empty
MemoryPrintReport print_box(const BoxPart& part, std::uint64_t seed, const std::function<void()>& layer = {});

/// Returns the wall of such a print in as many as four bands of whole intervals above the plate, for the
/// caliper.
std::vector<WallBand> wall_bands(const BoxPart& part, const MemoryPrintReport& print);

}  // namespace firn::barnett
