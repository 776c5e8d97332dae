// Writes a mesh with its object and material names, as an exporter of a simulator would.
#pragma once

#include <string>

#include "mesh/mesh.h"
#include "mesh/read_mesh.h"

namespace road {

struct MeshExportOptions {
  UpAxis up = UpAxis::z;  ///< turned_from_z(); y: (x, y, z) is written as (x, z, -y)
  Unit unit = Unit::m;    ///< coordinates are written in this unit; automatic counts as m
};

/// Writes .obj (+ .mtl), .glb, .ply or .stl by the ending of `path`, whole or not at all. Vertices
/// are shared inside an object, not between objects. .obj and .glb keep object and material names
/// (objects with empty names become one unnamed object); .glb has normals, smooth over the edges,
/// and the objects' colours as those of their materials; .ply holds float64, .glb and .stl float32
/// coordinates, .obj 1e-5 m. assimp (glb) stays private to the source file. Throws Error.
void export_mesh(const Mesh& mesh, const std::string& path, const MeshExportOptions& options = {});

}  // namespace road
