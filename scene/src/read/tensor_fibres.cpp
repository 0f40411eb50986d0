#include "maille/images/image.hpp"
#include "maille/scene/fibre/fibre_field.hpp"
#include "maille/scene/voxel_map.hpp"
#include "read/reader.hpp"
#include "voxels/label_cells.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

using Tensor = Eigen::Matrix3d;

/// Reason why a cell has no direction.
enum class Lack { nothing, no_tensor, not_positive, isotropic };

/// Order of the six components of a tensor: xx yy zz xy xz yz, or FSL's xx xy xz yy yz zz.
using Order = std::array<std::size_t, 6>;
constexpr Order own_order{0, 1, 2, 3, 4, 5}, order_of_fsl{0, 3, 5, 1, 2, 4};

/// The tensor of one voxel, component slowest.
Tensor voxel_tensor(const Image& image, std::size_t voxel, const Order& order = own_order) {
  const std::size_t n = image.info.n_voxels();
  std::array<double, 6> t{};
  for (std::size_t c = 0; c < 6; ++c)
    t[c] = double{image.values[order[c] * n + voxel]};
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

/// Transformation from the axes of the file's tensors (of the header; without them, the voxel axes) to the
/// body's; exact if both are equal except for order or direction.
Tensor to_body(const ImageInfo& info, const Specimen& body) {
  const ImageInfo seen = in_world(info, body.placement.world);
  const std::array<Vec3, 3> from = seen.vectors_to_world.value_or(seen.direction);
  Tensor turn = Tensor::Zero();
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      double& entry = turn(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
      for (std::size_t row = 0; row < 3; ++row)
        entry += body.placement.direction[row][a] * from[row][b];
      if (constexpr double rounding = 1e-4; std::abs(entry - std::round(entry)) < rounding)
        entry = std::round(entry);
    }
  return turn;
}

/// Angle between the voxel axes and the world's, in any order [degrees].
double obliqueness(const ImageInfo& info) {
  double least = 1;
  for (std::size_t a = 0; a < 3; ++a)
    least = std::min(least, std::max({std::abs(info.direction[0][a]), std::abs(info.direction[1][a]),
                                      std::abs(info.direction[2][a])}));
  return std::acos(std::min(least, 1.0)) * 180 / std::numbers::pi;
}

/// Number of voxels with a tensor, and of those where it is positive, per order of components.
struct PositiveTensors {
  std::int64_t all = 0, own = 0, of_fsl = 0;
};
PositiveTensors count_positive(const Image& image, const LabelCells& labels) {
  PositiveTensors n;
  labels.for_each_cell([&](std::int64_t, const std::vector<std::size_t>& voxels) {
    for (const std::size_t voxel : voxels) {
      const Tensor tensor = voxel_tensor(image, voxel);
      if (!tensor.allFinite() || tensor.isZero(0))
        continue;
      ++n.all;
      n.own += is_positive(tensor) ? 1 : 0;
      n.of_fsl += is_positive(voxel_tensor(image, voxel, order_of_fsl)) ? 1 : 0;
    }
  });
  return n;
}

/// Reads directions of cells from their tensors. @return true for cells with a direction
std::vector<bool> read_directions(const Image& image, const Tensor& turn, const LabelCells& labels,
                                  Specimen& body) {
  const std::size_t n = body.grid.n_cells();
  FibreReport& report = body.fibre_report;
  body.fibres.assign(n, {0, 0, 0});
  std::vector<bool> is_known(n, false);
  labels.for_each_cell([&](std::int64_t number, const std::vector<std::size_t>& voxels) {
    const std::size_t cell = number;
    Lack lack{};
    const Tensor tensor = sum_of_tensors(image, voxels, lack);
    if (lack == Lack::nothing) {
      const auto direction =
          first_eigenvector(turn.isIdentity(0) ? tensor : turn * tensor * turn.transpose());
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

/// Upper bound of the pairs of cells in smoothing.
double sums_of_smoothing(const Specimen& body, double radius) {
  double cells = 1;
  for (int a = 0; a < body.grid.dimension(); ++a) {
    const std::size_t axis = a;
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
  if (!have_same_voxels(on_body(info, body), labels.info())) {
    faults.add(request.line, path, "a tensor image on the voxels of the labels, " + words(labels.info()),
               words(info));
    return;
  }
  FibreReport& report = body.fibre_report;
  report = {};
  report.source = "tensor_image";
  Image image = read_image(file);
  image.info = in_world_of(info, body);
  image = along_axes(std::move(image), body.placement.direction);
  if (const PositiveTensors n = count_positive(image, labels); 2 * n.own < n.all) {
    faults.add(
        request.line, path, "a tensor image that is positive in most voxels, in the order xx yy zz xy xz yz",
        fmt::format("{} of {} that are not{}", n.all - n.own, n.all,
                    n.of_fsl > n.own ? fmt::format("; in FSL's order, xx xy xz yy yz zz, {} are", n.of_fsl)
                                     : std::string()));
    return;
  }
  if (const double angle = obliqueness(info); !info.vectors_to_world && angle > 1)
    warn_of_file(
        file, fmt::format("does not state what its tensors are along: taken along the voxels' axes, as FSL "
                          "writes them; those along the world's (MRtrix, DIPY) would be turned by {:.3g} "
                          "degrees",
                          angle));
  std::vector<bool> is_known = read_directions(image, to_body(in_world_of(info, body), body), labels, body);
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
