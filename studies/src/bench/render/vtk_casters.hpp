#pragma once
/// VTK's ray casters on the processor, without a screen: rivals of `maille bench render`.

#include "maille/render/renderer.hpp"

#include <memory>
#include <span>
#include <string>

namespace maille::studies {

class VtkCasters {
public:
  /// @return null where nothing can be drawn on this machine; `why_not` says why
  static std::unique_ptr<VtkCasters> open(int width, int height, std::string& why_not);
  ~VtkCasters();
  VtkCasters(const VtkCasters&) = delete;
  VtkCasters& operator=(const VtkCasters&) = delete;

  /// Takes everything away.
  void clear();
  /// A volume by vtkFixedPointVolumeRayCastMapper on one thread. @param values 16 bits are kept of them
  /// @return its number
  int add_rigid(const render::VoxelGrid& grid, std::span<const float> values, const Look& look, double step);
  void move(int volume, const Vec3& to);
  /// A lattice by vtkUnstructuredGridVolumeRayCastMapper on one thread: five tetrahedra a cell.
  /// @param values of its nodes
  void add_deformed(const render::Deformation& deformation, std::span<const float> values, const Look& look);
  /// The same grid as regular voxels, by vtkResampleToImage. @return the voxels' values
  std::vector<float> resample(const render::Deformation& deformation, std::span<const float> values, int n,
                              render::VoxelGrid& grid) const;
  void look_from(const render::Camera& camera);
  void render();
  /// Of the last picture over black, rows from the top, three bytes a pixel.
  std::vector<std::uint8_t> pixels() const;

private:
  struct Parts;
  VtkCasters();
  std::unique_ptr<Parts> parts_;
};

} // namespace maille::studies
