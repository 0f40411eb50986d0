#pragma once
/// Worlds of several objects as files for ParaView: a file an object and moment, and one list of all.

#include "export/vtk_files.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace maille::studies {

/// Where the nodes of an object's whole grid are, in the world [m]; of nodes without matter any point.
using NodePositions = std::shared_ptr<const std::vector<Vec3>>;

/// All objects of a world at one moment, in the scene's order. An object that has not moved since the last
/// moment has the same pointer, not a copy, so that files and pictures can tell.
struct WorldMoment {
  double time = 0; ///< [s]
  std::vector<NodePositions> objects;
  std::vector<Vec3> contacts; ///< where objects touch, for pictures [m]
};

/// @brief Collects a world's moments in `stem.pvd`: one time step each, a part an object.
///
/// A part is a file `stem_OBJECT_0012.vtu` (signs other than plain letters become `_`; a repeated name
/// becomes `OBJECT-2`): the object's cells at that moment, in world coordinates. If the object has not moved,
/// the file of the moment before is listed again, so that a wall is written once.
/// Same form as write_vtk's files:
/// - points: Displacement [m], from where the object was in the first moment
/// - cells: ObjectId (number in the scene), MaterialId, FiberDirection; of deformable objects also what
///   write_vtk has of strain, and of stress where the world's method knows one; tensors in the world's frame
///   as the object stood when the world began
/// - field: ObjectName, Units, Provenance, TimeValue (of when it was written)
///
/// write() may be called after any moment: files appear whole or not at all, so what is there can always be
/// opened.
class WorldSeries {
public:
  /// @param world  outlives this @param n_moments  to come; decides how many digits names get @param unit  of
  /// places and displacements
  WorldSeries(const WorldScene& world, std::filesystem::path stem, std::size_t n_moments,
              std::string provenance, LengthUnit unit = LengthUnit::metre);
  /// @throws as write_vtk
  void add(const WorldMoment& moment);
  /// @return the list's path; @throws as write_pvd
  std::filesystem::path write() const;
  std::size_t n_files() const { return files_.size(); }
  /// Written so far, without the list.
  const std::vector<std::filesystem::path>& files() const { return files_; }

private:
  struct Shown {
    NodePositions start, last;
    std::filesystem::path file;
  };

  const WorldScene& world_;
  std::filesystem::path stem_;
  int n_digits_;
  std::string provenance_;
  LengthUnit unit_;
  std::vector<std::string> names_; ///< of the objects, in files' names
  std::vector<Shown> shown_;
  std::vector<PvdEntry> entries_;
  std::vector<std::filesystem::path> files_;
  std::size_t n_moments_ = 0;
};

} // namespace maille::studies
