#!/bin/sh
# What a mesh costs as binary STL and as 3MF: processor time of `firn slice` without support, in turn.
#   ./firn bench mesh_reading MESH.ply [--rounds N] [--firn PROGRAM]
# MESH.ply is a binary one of float vertices and triangles, as `igea_269k.ply` of the shared models.
set -eu
exec python3 -B "$(dirname "$0")/mesh_reading.py" "$@"
