#include "bench/render/vtk_casters.hpp"

#include "picture/drawing.hpp"

#include <vtkCamera.h>
#include <vtkCellType.h>
#include <vtkColorTransferFunction.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkResampleToImage.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridVolumeRayCastMapper.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>

namespace maille::lab {

namespace {

vtkSmartPointer<vtkVolumeProperty> property_of(const Look& look, double unit) {
  vtkNew<vtkColorTransferFunction> colours;
  for (const ColourPoint& point : look.colours)
    colours->AddRGBPoint(point.value, point.colour[0], point.colour[1], point.colour[2]);
  vtkNew<vtkPiecewiseFunction> opacity;
  for (const OpacityPoint& point : look.opacity)
    opacity->AddPoint(point.value, point.opacity);
  auto property = vtkSmartPointer<vtkVolumeProperty>::New();
  property->SetColor(colours);
  property->SetScalarOpacity(opacity);
  property->SetScalarOpacityUnitDistance(unit);
  property->SetInterpolationTypeToLinear();
  property->SetShade(look.shading.on ? 1 : 0);
  property->SetAmbient(look.shading.ambient);
  property->SetDiffuse(look.shading.diffuse);
  property->SetSpecular(look.shading.specular);
  property->SetSpecularPower(look.shading.shininess);
  return property;
}

vtkSmartPointer<vtkUnstructuredGrid> tetrahedra(const render::Deformation& deformation,
                                                std::span<const float> values) {
  const render::Lattice& lattice = deformation.lattice();
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> scalars;
  for (std::int64_t node = 0; node < lattice.n_nodes(); ++node) {
    points->InsertNextPoint(deformation.position(node).data());
    scalars->InsertNextValue(values[static_cast<std::size_t>(node)]);
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->GetPointData()->SetScalars(scalars);
  const Index3 n = lattice.nodes();
  // Five tetrahedra of a cube, mirrored from cell to cell so that their faces meet.
  constexpr int even[5][4] = {{0, 1, 3, 5}, {0, 3, 2, 6}, {0, 5, 4, 6}, {3, 5, 6, 7}, {0, 3, 5, 6}};
  constexpr int odd[5][4] = {{1, 0, 2, 4}, {1, 2, 3, 7}, {1, 4, 5, 7}, {2, 6, 4, 7}, {1, 2, 4, 7}};
  grid->Allocate(5 * lattice.n_cells());
  for (int k = 0; k < lattice.cells[2]; ++k)
    for (int j = 0; j < lattice.cells[1]; ++j)
      for (int i = 0; i < lattice.cells[0]; ++i)
        for (const auto& tetrahedron : (i + j + k) % 2 == 0 ? even : odd) {
          vtkIdType ids[4];
          for (int c = 0; c < 4; ++c) {
            const int corner = tetrahedron[c];
            ids[c] =
                i + (corner & 1) +
                std::int64_t{n[0]} * (j + ((corner >> 1) & 1) + std::int64_t{n[1]} * (k + (corner >> 2)));
          }
          grid->InsertNextCell(VTK_TETRA, 4, ids);
        }
  return grid;
}

class Casters final : public VtkCasters {
public:
  explicit Casters(std::unique_ptr<studies::OffscreenWindow> window) : window_(std::move(window)) {
    renderer_->SetBackground(0, 0, 0);
    window_->window().AddRenderer(renderer_);
  }

  void clear() override;
  int add_rigid(const render::VoxelGrid& grid, std::span<const float> values, const Look& look,
                double step) override;
  void move(int volume, const Vec3& to) override;
  void add_deformed(const render::Deformation& deformation, std::span<const float> values,
                    const Look& look) override;
  std::vector<float> resample(const render::Deformation& deformation, std::span<const float> values, int n,
                              render::VoxelGrid& grid) const override;
  void look_from(const render::Camera& camera) override;
  void render() override;
  std::vector<std::uint8_t> pixels() const override;

private:
  std::unique_ptr<studies::OffscreenWindow> window_;
  vtkNew<vtkRenderer> renderer_;
  std::vector<vtkSmartPointer<vtkVolume>> volumes_;
};

void Casters::clear() {
  renderer_->RemoveAllViewProps();
  volumes_.clear();
}

int Casters::add_rigid(const render::VoxelGrid& grid, std::span<const float> values, const Look& look,
                       double step) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(grid.size[0], grid.size[1], grid.size[2]);
  image->SetSpacing(grid.spacing.data());
  image->SetOrigin(grid.origin.data());
  image->AllocateScalars(VTK_UNSIGNED_SHORT, 1);
  auto* to = static_cast<std::uint16_t*>(image->GetScalarPointer());
  for (const float value : values)
    *to++ = static_cast<std::uint16_t>(std::clamp(value, 0.0f, 65535.0f) + 0.5f);
  vtkNew<vtkFixedPointVolumeRayCastMapper> mapper;
  mapper->SetInputData(image);
  mapper->AutoAdjustSampleDistancesOff();
  mapper->LockSampleDistanceToInputSpacingOff();
  mapper->SetSampleDistance(static_cast<float>(step));
  mapper->SetInteractiveSampleDistance(static_cast<float>(step));
  mapper->SetImageSampleDistance(1);
  mapper->SetNumberOfThreads(1);
  auto volume = vtkSmartPointer<vtkVolume>::New();
  volume->SetMapper(mapper);
  volume->SetProperty(property_of(look, *std::ranges::min_element(grid.spacing)));
  renderer_->AddVolume(volume);
  volumes_.push_back(volume);
  return static_cast<int>(volumes_.size()) - 1;
}

void Casters::move(int volume, const Vec3& to) {
  volumes_[static_cast<std::size_t>(volume)]->SetPosition(to[0], to[1], to[2]);
}

void Casters::add_deformed(const render::Deformation& deformation, std::span<const float> values,
                           const Look& look) {
  vtkNew<vtkUnstructuredGridVolumeRayCastMapper> mapper;
  mapper->SetInputData(tetrahedra(deformation, values));
  mapper->AutoAdjustSampleDistancesOff();
  mapper->SetImageSampleDistance(1);
  mapper->SetNumberOfThreads(1);
  auto volume = vtkSmartPointer<vtkVolume>::New();
  volume->SetMapper(mapper);
  volume->SetProperty(property_of(look, *std::ranges::min_element(deformation.lattice().spacing)));
  volume->GetProperty()->ShadeOff(); // it knows no light
  renderer_->AddVolume(volume);
  volumes_.push_back(volume);
}

std::vector<float> Casters::resample(const render::Deformation& deformation, std::span<const float> values,
                                     int n, render::VoxelGrid& grid) const {
  vtkNew<vtkResampleToImage> resampler;
  resampler->SetInputDataObject(tetrahedra(deformation, values));
  resampler->SetSamplingDimensions(n, n, n);
  resampler->Update();
  vtkImageData* image = resampler->GetOutput();
  for (int a = 0; a < 3; ++a) {
    const auto c = static_cast<std::size_t>(a);
    grid.size[c] = n;
    grid.spacing[c] = image->GetSpacing()[a];
    grid.origin[c] = image->GetOrigin()[a];
  }
  vtkDataArray* scalars = image->GetPointData()->GetArray(0);
  std::vector<float> out;
  for (vtkIdType i = 0; i < scalars->GetNumberOfTuples(); ++i)
    out.push_back(static_cast<float>(scalars->GetComponent(i, 0)));
  return out;
}

void Casters::look_from(const render::Camera& camera) {
  vtkCamera* to = renderer_->GetActiveCamera();
  to->SetPosition(camera.position.data());
  to->SetFocalPoint(camera.focal_point.data());
  to->SetViewUp(camera.view_up.data());
  to->SetViewAngle(camera.view_angle);
  renderer_->ResetCameraClippingRange();
}

void Casters::render() {
  window_->window().Render();
}

std::vector<std::uint8_t> Casters::pixels() const {
  vtkRenderWindow& window = window_->window();
  const int width = window.GetSize()[0], height = window.GetSize()[1];
  vtkNew<vtkUnsignedCharArray> data;
  window.GetPixelData(0, 0, width - 1, height - 1, 0, data);
  std::vector<std::uint8_t> out(static_cast<std::size_t>(3 * width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
    std::copy_n(data->GetPointer(static_cast<std::ptrdiff_t>(3) * width * (height - 1 - y)), 3 * width,
                out.begin() + static_cast<std::ptrdiff_t>(3) * width * y);
  return out;
}

constexpr VtkCasterFunctions functions{
    .open = [](int width, int height, std::string& why_not) -> std::unique_ptr<VtkCasters> {
      auto window = studies::OffscreenWindow::open(width, height, why_not);
      return window ? std::make_unique<Casters>(std::move(window)) : nullptr;
    },
};

} // namespace

} // namespace maille::lab

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void*) {
  return layout == maille::lab::vtk_casters_layout ? &maille::lab::functions : nullptr;
}
