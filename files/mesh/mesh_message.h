// send_mesh and receive_mesh carry a mesh, or the problem with its file, through a pipe. The receiver trusts
// nothing: the sender has read hostile bytes.
#pragma once

#include <cstddef>
#include <string>

#include "files/mesh/mesh_file.h"

namespace firn::mesh {

/// Vertices, triangles, unit and defects; the mesh has no soup and no records.
void send_mesh(int fd, const MeshData& data);
void send_problem(int fd, const std::string& problem);

/// @param limit_bytes of vertices and triangles together
/// @throws UsageError: the problem that was sent; std::runtime_error naming the field: an ended pipe, counts
/// beyond the limit, a triangle without its vertices
MeshData receive_mesh(int fd, std::size_t limit_bytes);

}  // namespace firn::mesh
