#include "image/label_cells.hpp"
#include "maille/scene/fibre/fibre_field.hpp"
#include "maille/scene/image.hpp"
#include "read/reader.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

using Tensor = Eigen::Matrix3d;

/// Why a cell has no direction of its own.
enum class Lack { nothing, no_tensor, not_positive, isotropic };

/// The tensor of one voxel: xx yy zz xy xz yz, component slowest.
Tensor voxel_tensor(const Image& image, std::size_t voxel) {
  const auto n = static_cast<std::size_t>(image.info.n_voxels());
  std::array<double, 6> t{};
  for (std::size_t c = 0; c < 6; ++c)
    t[c] = double{image.values[c * n + voxel]};
  Tensor tensor;
  tensor << t[0], t[3], t[4], t[3], t[1], t[5], t[4], t[5], t[2];
  return tensor;
}

bool is_positive(const Tensor& tensor) {
  return Eigen::SelfAdjointEigenSolver<Tensor>(tensor, Eigen::EigenvaluesOnly).eigenvalues()(0) > 0;
}

/// Sum of the positive tensors of some voxels.
Tensor sum_of_tensors(const Image& image, const std::vector<std::size_t>& voxels, Lack& lack) {
  Tensor sum = Tensor::Zero();
  lack = Lack::no_tensor;
  for (const std::size_t voxel : voxels) {
    const Tensor tensor = voxel_tensor(image, voxel);
    if (!tensor.allFinite() || tensor.isZero(0))
      continue;
    if (!is_positive(tensor)) {
      lack = lack == Lack::no_tensor ? Lack::not_positive : lack;
      continue;
    }
    sum += tensor;
    lack = Lack::nothing;
  }
  return sum;
}

} // namespace

bool have_same_voxels(const ImageInfo& one, const ImageInfo& other) {
  bool same = one.size == other.size;
  for (std::size_t a = 0; a < 3; ++a) {
    same = same && std::abs(one.spacing[a] - other.spacing[a]) <= 1e-3 * one.spacing[a];
    same = same && std::abs(one.origin[a] - other.origin[a]) <= 1e-3 * one.spacing[a];
    for (std::size_t b = 0; b < 3; ++b)
      same = same && std::abs(one.direction[a][b] - other.direction[a][b]) <= 1e-3;
  }
  return same;
}

namespace {

std::string words(const ImageInfo& info) {
  return fmt::format("{} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} m from ({:.4g}, {:.4g}, {:.4g}) m",
                     info.size[0], info.size[1], info.size[2], info.spacing[0], info.spacing[1],
                     info.spacing[2], info.origin[0], info.origin[1], info.origin[2]);
}

/// Directions of the cells whose tensors have one, and which those are.
std::vector<bool> read_directions(const Image& image, const LabelCells& labels, Specimen& body) {
  const auto n = static_cast<std::size_t>(body.grid.n_cells());
  FibreReport& report = body.fibre_report;
  body.fibres.assign(n, {0, 0, 0});
  std::vector<bool> is_known(n, false);
  labels.for_each_cell([&](std::int64_t number, const std::vector<std::size_t>& voxels) {
    const auto cell = static_cast<std::size_t>(number);
    Lack lack{};
    const Tensor tensor = sum_of_tensors(image, voxels, lack);
    if (lack == Lack::nothing) {
      const auto direction = first_eigenvector(tensor);
      body.fibres[cell] = direction.value_or(std::array<float, 3>{0, 0, 0});
      is_known[cell] = direction.has_value();
      lack = direction ? Lack::nothing : Lack::isotropic;
    }
    ++report.cells;
    report.no_tensor += lack == Lack::no_tensor ? 1 : 0;
    report.not_positive += lack == Lack::not_positive ? 1 : 0;
    report.isotropic += lack == Lack::isotropic ? 1 : 0;
  });
  return is_known;
}

constexpr double most_sums = 5e10; // some half a minute

/// Pairs of cells of matter that smoothing looks at, at most.
double sums_of_smoothing(const Specimen& body, double radius) {
  double cells = 1;
  for (int a = 0; a < body.grid.dimension(); ++a) {
    const auto axis = static_cast<std::size_t>(a);
    cells *= std::min(2 * radius / body.grid.spacing()[axis] + 1, 2.0 * body.grid.cells()[axis]);
  }
  return cells * static_cast<double>(body.n_matter_cells());
}

} // namespace

void fibres_from_tensors(const std::filesystem::path& file, const FibreRequest& request,
                         const LabelCells& labels, const std::string& path, FaultList& faults,
                         Specimen& body) {
  const ImageInfo info = read_image_info(file);
  if (info.components != 6) {
    faults.add(request.line, path, "a tensor image with 6 values a voxel: xx yy zz xy xz yz",
               fmt::format("{} a voxel", info.components));
    return;
  }
  if (!have_same_voxels(info, labels.info())) {
    faults.add(request.line, path, "a tensor image on the voxels of the labels, " + words(labels.info()),
               words(info));
    return;
  }
  FibreReport& report = body.fibre_report;
  report = {};
  report.source = "tensor_image";
  std::vector<bool> is_known = read_directions(read_image(file), labels, body);
  if (report.without_direction() == report.cells) {
    faults.add(request.line, path, "a tensor image with a direction in at least one voxel of the body",
               fmt::format("none in {} cells", report.cells));
    return;
  }
  FibreField field(body, labels.regions(), std::move(is_known));
  if (const double sums = sums_of_smoothing(body, request.smoothing_radius); sums > most_sums) {
    faults.add(request.line, path + ".smooth",
               fmt::format("a radius with at most {:.0e} pairs of cells within it, some {:.2g} m here",
                           most_sums, request.smoothing_radius * std::cbrt(most_sums / sums)),
               fmt::format("{:.2g} m, with some {:.0e} pairs", request.smoothing_radius, sums));
    return;
  }
  if (request.smoothing_radius > 0) {
    report.smoothing_radius = request.smoothing_radius;
    report.smoothing_turn = field.smooth(request.smoothing_radius);
  }
  field.fill(report);
}

} // namespace maille::reader
