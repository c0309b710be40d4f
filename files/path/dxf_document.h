// dxf::read_document reads the entities, blocks, layers and units of an ASCII DXF file: a list of pairs of
// lines, a group code and its value.
//
// The reader is Firn's own: dxflib, the library in Debian, is under the GPL, which Firn is not.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/path/path.h"

namespace firn::dxf {

struct Group {
  int code = 0;
  double value = 0.0;
  double place = 1.0;  ///< of the last decimal: 0.001 for 2.500
};

struct PolylineVertex {
  Point2 at;  ///< in the drawing's unit, as all of an entity
  double z = 0.0, bulge = 0.0;
};

struct Entity {
  std::string type, layer;
  std::string block;          ///< an INSERT's, in small letters
  std::vector<Group> groups;  ///< its numbers, in the file's order
  std::vector<PolylineVertex> vertices;
  std::size_t line = 0;

  double operator()(int code, double otherwise) const;
  bool flag(int code, int bit) const;
  /// Place of the last decimal of a number; 0 where the entity does not have it.
  double place(int code) const;
};

struct Block {
  Point2 base;
  double z = 0.0;
  bool external = false;  ///< drawn in another file
  std::vector<Entity> entities;
};

struct Layer {
  bool off = false;  ///< or not plotted
  bool frozen = false;
};

/// Names of layers and blocks are in small letters: AutoCAD does not distinguish them by case.
struct Document {
  double unit_mm = 1.0;
  bool imperial = false;  ///< by $MEASUREMENT; unit_mm is a guess then
  std::map<std::string, Layer, std::less<>> layers;
  std::map<std::string, Block, std::less<>> blocks;
  std::vector<Entity> entities;
};

/// Types of entities that are curves, or hold some.
inline constexpr std::array<std::string_view, 8> kDrawn{"LINE",       "ARC",      "CIRCLE", "ELLIPSE",
                                                        "LWPOLYLINE", "POLYLINE", "SPLINE", "INSERT"};

/// @throws UsageError naming file and line: of a binary file, of a text that is no group code or number, of a
/// $INSUNITS that is not known, and of a file that ends before its EOF
Document read_document(std::istream& in, const std::string& name);

}  // namespace firn::dxf
