// MeshBuilder collects the vertices and triangles of an indexed mesh as all of its readers do: coordinates
// about an origin near them, facets that name a vertex twice left out and counted, polygons cut into
// triangles.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "files/mesh/mesh_file.h"

namespace firn::mesh {

/// Subtracts the first point from all points, axis by axis, where it lies so far from 0 that floats would
/// lose digits of the file: maps and scanners give coordinates of kilometres.
class NearOrigin {
 public:
  slice::Corner operator()(const std::array<double, 3>& p) {
    if (is_first_) choose(p);
    return {float(p[0] - at_[0]), float(p[1] - at_[1]), float(p[2] - at_[2])};
  }
  const std::array<double, 3>& at() const { return at_; }

 private:
  void choose(const std::array<double, 3>& p);
  std::array<double, 3> at_{};
  bool is_first_ = true;
};

class MeshBuilder {
 public:
  MeshData& data() { return data_; }
  void add_vertex(const std::array<double, 3>& p) { data_.vertices.push_back(near_(p)); }
  /// @param corners may name vertices that follow
  /// @param place of the facet in the file, for finish()
  void add_facet(std::span<const std::uint32_t> corners, std::size_t place);
  /// Cuts concave polygons anew, now that all vertices are known, and writes the defects.
  /// @param place_text names a place: "line 17"
  /// @pre each corner has its vertex
  MeshData finish(const std::function<std::string(std::size_t)>& place_text);

 private:
  struct Polygon {
    std::size_t first;  ///< of its triangles, which are a fan
    std::uint32_t corners;
  };
  void leave_out(std::size_t place);

  MeshData data_;
  NearOrigin near_;
  std::vector<Polygon> polygons_;  ///< of more than three corners
  std::vector<std::uint32_t> distinct_;
  std::size_t thin_ = 0, degenerate_ = 0, first_degenerate_ = 0;
};

}  // namespace firn::mesh
