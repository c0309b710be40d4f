// SlicerRoles holds the roles that slicers give to the volumes of a 3MF file in a part of their own
// (PrusaSlicer, SuperSlicer: Metadata/Slic3r_PE_model.config; Bambu Studio, OrcaSlicer:
// Metadata/model_settings.config), which 3MF itself knows nothing of.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "files/mesh/model_3mf.h"

namespace firn::mesh {

struct SlicerRoles {
  struct OfObject {
    std::vector<Volume3mf> volumes;               ///< by triangles of the object's own mesh
    std::map<std::string, Volume3mf> components;  ///< by the id of the component's object
  };
  std::map<std::string, OfObject> objects;  ///< by id, of the root model
  std::size_t plates = 0;                   ///< on which the objects lie; 0: not said
};

/// @throws UsageError naming file, part, line and column: no XML, triangles that are no numbers
SlicerRoles read_slicer_roles(ZipPackage& package);

enum class VolumeUse {
  kPrinted,
  kLeftOut,  ///< it changes settings or supports, and no solid: modifier, support enforcer or blocker
  kRefused,  ///< it is cut out of the solid, or nobody knows
};
VolumeUse use_of_role(const std::string& role);

}  // namespace firn::mesh
