#pragma once
/// VTK's ray casters on the processor, without a screen: rivals of `studies/lab/run render`, in a plugin of
/// their own, maille-vtk-casters.so.

#include "maille/plugins/open_plugin.hpp"
#include "maille/render/renderer.hpp"

#include <memory>
#include <span>
#include <string>

namespace maille::lab {

class VtkCasters {
public:
  /// Opens the plugin. @return null where nothing can be drawn on this machine; `why_not` says why
  static std::unique_ptr<VtkCasters> open(int width, int height, std::string& why_not);
  VtkCasters() = default;
  virtual ~VtkCasters() = default;
  VtkCasters(const VtkCasters&) = delete;
  VtkCasters& operator=(const VtkCasters&) = delete;

  /// Takes everything away.
  virtual void clear() = 0;
  /// A volume by vtkFixedPointVolumeRayCastMapper on one thread. @param values 16 bits are kept of them
  /// @return its number
  virtual int add_rigid(const render::VoxelGrid& grid, std::span<const float> values, const Look& look,
                        double step) = 0;
  virtual void move(int volume, const Vec3& to) = 0;
  /// A lattice by vtkUnstructuredGridVolumeRayCastMapper on one thread: five tetrahedra a cell.
  /// @param values of its nodes
  virtual void add_deformed(const render::Deformation& deformation, std::span<const float> values,
                            const Look& look) = 0;
  /// The same grid as regular voxels, by vtkResampleToImage. @return the voxels' values
  virtual std::vector<float> resample(const render::Deformation& deformation, std::span<const float> values,
                                      int n, render::VoxelGrid& grid) const = 0;
  virtual void look_from(const render::Camera& camera) = 0;
  virtual void render() = 0;
  /// Pixels of the last picture over black, rows from the top, three bytes a pixel.
  virtual std::vector<std::uint8_t> pixels() const = 0;
};

/// What the plugin is asked for.
struct VtkCasterFunctions {
  std::unique_ptr<VtkCasters> (*open)(int width, int height, std::string& why_not);
};
inline constexpr std::size_t vtk_casters_layout =
    layout_of<VtkCasterFunctions, VtkCasters, render::VoxelGrid, render::Deformation, render::Camera, Look>();

} // namespace maille::lab
