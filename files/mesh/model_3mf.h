// Model3mf holds one model part of a 3MF file as it is written: its objects, components and build items
// (3MF core specification 1.3), and each thing in it that changes the solid and that Firn does not read.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "files/mesh/zip_package.h"

namespace firn::mesh {

/// Rows are the images of the axes and the origin (core specification, 3.3): p' = p * matrix.
using Transform3mf = std::array<std::array<double, 3>, 4>;
inline constexpr Transform3mf kNoTransform{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};

/// The place of one object: a component of another object, or an item of the build.
struct Placed3mf {
  std::string object;  ///< its id
  std::string path;    ///< of the model part that has it (production extension); empty: this part
  Transform3mf at = kNoTransform;
  bool printable = true;
};

/// The role of some triangles of an object, as a slicer wrote it. Only `part` is material.
struct Volume3mf {
  std::size_t first = 0, behind = 0;  ///< triangles
  std::string role;                   ///< "" = part, else the file's word: "NegativeVolume"
  std::string name;
};

struct Object3mf {
  std::string type = "model";
  bool has_mesh = false;
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< each index has its vertex
  std::vector<Placed3mf> components;
  std::vector<Volume3mf> volumes;     ///< that the model itself names (Slic3r, Cura)
  std::string refused;                ///< why this object cannot be placed; empty: it can
  std::vector<std::string> not_read;  ///< names of elements of other namespaces
};

struct Model3mf {
  double mm_per_unit = 1.0;
  std::map<std::string, Object3mf> objects;  ///< by id
  std::vector<Placed3mf> items;
};

/// @param max_bytes of vertices and triangles
/// @throws UsageError naming file, part, line and column: a text that is no number, an index without vertex,
/// a required extension that changes the solid
Model3mf read_model_3mf(ZipPackage& package, const std::string& part, std::size_t max_bytes);

}  // namespace firn::mesh
