// Reads a simulator's track mesh into metres, z up. assimp stays private to the source file.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mesh/error.h"
#include "mesh/mesh.h"
#include "mesh/up_axis.h"

namespace road {

enum class Unit { automatic, m, cm, mm, ft, inch, yard, km, mile };

struct NamedUnit {
  Unit unit;
  const char* name;
  double metres;
};
/// Every unit but `automatic`.
inline constexpr NamedUnit kUnits[] = {
    {Unit::m, "m", 1.0},      {Unit::cm, "cm", 0.01},        {Unit::mm, "mm", 0.001},
    {Unit::ft, "ft", 0.3048}, {Unit::inch, "inch", 0.0254},  {Unit::yard, "yard", 0.9144},
    {Unit::km, "km", 1000.0}, {Unit::mile, "mile", 1609.344}};

/// automatic counts as m.
constexpr double metres_per(Unit unit) {
  for (const NamedUnit& known : kUnits)
    if (known.unit == unit) return known.metres;
  return 1.0;
}

/// automatic for any other word.
constexpr Unit unit_called(std::string_view name) {
  for (const NamedUnit& known : kUnits)
    if (name == known.name) return known.unit;
  return Unit::automatic;
}

struct MeshReadOptions {
  /// automatic: the line along which the large flat faces point, in the direction that at least
  /// 90 % of them look to. Where they look both ways, or the format has a rule for this line (.ac,
  /// .acc, .b3d, .dae, .gltf, .glb: y; .fbx: what it states), the format's direction; else the
  /// positive one.
  UpAxis up = UpAxis::automatic;
  /// automatic: metres, refused when the size of the mesh speaks against it (see read_mesh).
  Unit unit = Unit::automatic;
  /// Factor on top of the unit, for meshes whose unit has no name.
  double scale = 1.0;
  /// Reflects the plan, for files in which left and right are exchanged.
  bool mirror = false;
  /// Files that the mesh refers to (.bin, .mtl) may lie outside the folder of the mesh. Not by
  /// default: a mesh from elsewhere shall not choose what is read here.
  bool allow_outside = false;
  /// Formats without a reader of our own, and .obj for its polygons, are read in a child process,
  /// so that a crash of the foreign reader, or taking far too long, is a refusal. false, for
  /// debuggers and fuzzers: in this one.
  bool own_process = true;
  /// Asked once with the objects that the file holds: whether their colours are wanted. Pictures
  /// are read only then (PNG and JPEG, beside the mesh or in it); one that cannot be read leaves
  /// its objects without colour, with one remark for all. Empty: never.
  std::function<bool(const std::vector<MeshObject>&)> want_colours = {};
};

/// Neither a file nor the faces in it tell which axis points up.
class UnknownUp : public Error {
 public:
  UnknownUp(const std::string& what, std::vector<UpAxis> could_be)
      : Error(what), could_be_(std::move(could_be)) {}
  const std::vector<UpAxis>& could_be() const { return could_be_; }

 private:
  std::vector<UpAxis> could_be_;
};

/// The size of a mesh whose unit nobody stated is no road's in metres, and is one in other units.
class UnknownUnit : public Error {
 public:
  UnknownUnit(const std::string& what, std::vector<Unit> could_be)
      : Error(what), could_be_(std::move(could_be)) {}
  const std::vector<Unit>& could_be() const { return could_be_; }

 private:
  std::vector<Unit> could_be_;
};

/// A file that a mesh refers to.
struct MeshFile {
  std::string path;  ///< as it was opened: the mesh's folder in front
  std::string
      sha256;  ///< of the bytes that were used; empty: wanted, but not there or not readable
};
/// For base/archive.h.
template <class Archive, class File>
requires std::is_same_v<std::remove_const_t<File>, MeshFile>
void fields(Archive& archive, File& f) { archive(f.path, f.sha256); }

/// What was decided and seen while reading; for summary.json.
struct MeshReadReport {
  std::string up;                ///< "x" to "-z"
  std::string up_why;            ///< "from the faces of 14,210 triangles"
  bool mirrored = false;         ///< because the options say so
  std::string unit;              ///< "m", "cm", "mm", "ft", "inch", "yard", "km", "mile"
  bool unit_taken = false;       ///< metres, for neither the options nor the file state a unit
  double scale = 1.0;            ///< as in MeshReadOptions
  double metres_per_unit = 1.0;  ///< of the coordinates in the file: unit times scale
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t objects = 0;
  double coordinate_resolution_m =
      0.0;  ///< spacing of representable coordinates in the source file
  std::vector<std::string>
      remarks;  ///< plain sentences, e.g. coordinates quantised by the exporter
  /// Every file besides the mesh itself that was opened (.bin, .mtl ...) or looked for, once each,
  /// in the order of asking: when one of them changes, appears or goes, the mesh may read
  /// differently.
  std::vector<MeshFile> files;
};

/// Reads any format assimp knows (.obj .glb .gltf .ply .stl .fbx .dae .3ds .ac .acc ...), of glTF
/// also what is compressed by Draco, quantized or shown by instances. Source axes are turned
/// (turned_up()), never mirrored unless the options or the file say so. Large coordinates (UTM) of
/// text formats and of double PLY survive: a local origin is subtracted in double before assimp
/// sees them. Throws Error: missing, empty, truncated, a pointer of Git LFS or a web page in its
/// place, requires an extension of glTF that is not read, no triangles, not finite or > 1e7 m
/// coordinates (with object name and vertex), wrong axis or unit (what was seen, which flag to
/// give; UnknownUp, UnknownUnit), nested beyond reason, refers to geometry outside its folder, or
/// its reader crashed or took far too much time or memory.
Mesh read_mesh(const std::string& path, const MeshReadOptions& options = {},
               MeshReadReport* report = nullptr);

/// Writes triangles as binary .stl, .ply (binary, double coordinates) or .obj by the ending of
/// `path`, in map coordinates (origin added; STL is float32 by its format), whole or not at all.
/// `note` (one line) goes into the head of the file. The attribute of a triangle in .stl is its
/// object's number.
void write_mesh(const Mesh& mesh, const std::string& path, const std::string& note = {});

}  // namespace road
