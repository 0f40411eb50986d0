#pragma once
/// Worlds of several objects as files for ParaView: one file per object and moment, and one list.

#include "export/vtk_files.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace maille::studies {

/// Positions of the nodes of an object's whole grid, in the world [m]; arbitrary outside the body.
using NodePositions = std::shared_ptr<const std::vector<Vec3>>;

/// All objects of a world at one moment, in the scene's order. An unmoved object keeps its pointer from the
/// last moment, so that files and pictures can detect it.
struct WorldMoment {
  double time = 0; ///< [s]
  std::vector<NodePositions> objects;
  std::vector<Vec3> contacts; ///< contact points, for pictures [m]
};

/// @brief Collects a world's moments in `stem.pvd`: one time step each, a part an object.
///
/// A part is a file `stem_OBJECT_0012.vtu` (characters other than plain letters become `_`; a repeated name
/// becomes `OBJECT-2`): the object's cells at that moment, in world coordinates. For an unmoved object the
/// previous file is listed again, so a wall is written once.
/// Same form as files of write_vtk:
/// - points: Displacement [m], from the object's position at the first moment
/// - cells: ObjectId (number in the scene), MaterialId, FiberDirection; deformable objects also have the
/// strain arrays of write_vtk, and stress if the world's method has stress; tensors in the world's frame, for
/// the object's orientation at the start of the world
/// - field: ObjectName, Units, Provenance, TimeValue (time of writing)
///
/// write() may be called after any moment: files are atomic, so existing ones can always be opened.
class WorldSeries {
public:
  /// @param world  must outlive this @param n_moments  expected number; determines the digits in names @param
  /// unit  of positions and displacements
  WorldSeries(const WorldScene& world, std::filesystem::path stem, std::size_t n_moments,
              std::string provenance, LengthUnit unit = LengthUnit::metre);
  /// @throws as write_vtk
  void add(const WorldMoment& moment);
  /// @return the list's path; @throws as write_pvd
  std::filesystem::path write() const;
  std::size_t n_files() const { return files_.size(); }
  /// Files written so far, without the list.
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
  std::vector<std::string> names_; ///< names of the objects in file names
  std::vector<Shown> shown_;
  std::vector<PvdEntry> entries_;
  std::vector<std::filesystem::path> files_;
  std::size_t n_moments_ = 0;
};

} // namespace maille::studies
