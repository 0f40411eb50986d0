#include "maille/scene/image.hpp"
#include "reader.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <cmath>

namespace maille::reader {

namespace {

std::optional<Vec3> direction_from_list(const toml::array& list) {
  Vec3 v{};
  double largest = 0;
  if (list.size() != 3)
    return std::nullopt;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto value = list.get(a)->value<double>();
    if (!value || !std::isfinite(*value))
      return std::nullopt;
    v[a] = *value;
    largest = std::max(largest, std::abs(v[a]));
  }
  if (largest == 0)
    return std::nullopt;
  for (double& c : v)
    c /= largest; // so that squares neither overflow nor vanish
  const double length = std::hypot(v[0], v[1], v[2]);
  for (double& c : v)
    c /= length;
  return v;
}

/// `{ angle = "20 deg", plane = "xz" }`: turned from the first axis of the plane towards the second.
std::optional<Vec3> direction_from_angle(TableReader& table) {
  table.require("angle", "an angle");
  table.require("plane", "two axes, e.g. \"xz\"");
  const auto angle = table.quantity("angle", Dimension::angle);
  const auto plane = table.choice("plane", {"xy", "xz", "yz", "yx", "zx", "zy"});
  if (!angle || !plane)
    return std::nullopt;
  Vec3 v{};
  v[static_cast<std::size_t>((*plane)[0] - 'x')] = std::cos(*angle);
  v[static_cast<std::size_t>((*plane)[1] - 'x')] = std::sin(*angle);
  return v;
}

using Tensor = Eigen::Matrix3d;

/// Sum of the tensors of one block of voxels.
Tensor block_tensor(const Image& image, const Index3& first, const Index3& coarsen) {
  Tensor sum = Tensor::Zero();
  const Index3& size = image.info.size;
  const auto n = static_cast<std::size_t>(image.info.n_voxels());
  for (int k = first[2]; k < std::min(first[2] + coarsen[2], size[2]); ++k)
    for (int j = first[1]; j < std::min(first[1] + coarsen[1], size[1]); ++j)
      for (int i = first[0]; i < std::min(first[0] + coarsen[0], size[0]); ++i) {
        const auto v = static_cast<std::size_t>(i) +
                       static_cast<std::size_t>(size[0]) *
                           (static_cast<std::size_t>(j) +
                            static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(k));
        std::array<double, 6> t{};
        for (std::size_t c = 0; c < 6; ++c)
          t[c] = double{image.values[c * n + v]};
        Tensor here;
        here << t[0], t[3], t[4], t[3], t[1], t[5], t[4], t[5], t[2]; // xx yy zz xy xz yz
        if (here.allFinite())
          sum += here;
      }
  return sum;
}

/// Eigenvector of the largest eigenvalue; nothing where no direction stands out.
std::optional<std::array<float, 3>> principal_direction(const Tensor& tensor) {
  const Eigen::SelfAdjointEigenSolver<Tensor> solver(tensor);
  const Eigen::Vector3d values = solver.eigenvalues();
  if (!(values(2) > 0) || values(2) - values(1) <= 1e-9 * values(2))
    return std::nullopt;
  const Eigen::Vector3d v = solver.eigenvectors().col(2);
  return std::array<float, 3>{static_cast<float>(v(0)), static_cast<float>(v(1)), static_cast<float>(v(2))};
}

/// True if two images have the same voxels in the same places, to a thousandth of a voxel.
bool same_voxels(const ImageInfo& one, const ImageInfo& other) {
  bool same = one.size == other.size;
  for (std::size_t a = 0; a < 3; ++a) {
    same = same && std::abs(one.spacing[a] - other.spacing[a]) <= 1e-3 * one.spacing[a];
    same = same && std::abs(one.origin[a] - other.origin[a]) <= 1e-3 * one.spacing[a];
    for (std::size_t b = 0; b < 3; ++b)
      same = same && std::abs(one.direction[a][b] - other.direction[a][b]) <= 1e-3;
  }
  return same;
}

std::string words(const ImageInfo& info) {
  return fmt::format("{} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} m from ({:.4g}, {:.4g}, {:.4g}) m",
                     info.size[0], info.size[1], info.size[2], info.spacing[0], info.spacing[1],
                     info.spacing[2], info.origin[0], info.origin[1], info.origin[2]);
}

} // namespace

std::optional<FibreRequest> read_fibre(TableReader& table) {
  constexpr const char* wanted = "three numbers, { angle, plane } or { tensor_image }";
  FibreRequest request;
  const toml::node* node = table.find("fibre");
  if (!node)
    return request;
  request.line = line_of(*node);
  if (const auto* list = node->as_array()) {
    if (const auto v = direction_from_list(*list)) {
      request.direction = *v;
      return request;
    }
  } else if (const auto* values = node->as_table()) {
    TableReader reader(*values, table.path_of("fibre"), table.faults());
    if (reader.has("tensor_image")) {
      request.tensor_image = reader.text("tensor_image").value_or("");
      if (request.tensor_image.empty())
        reader.fault("tensor_image", "the name of an image", describe(*reader.find("tensor_image")));
      reader.finish();
      return request.tensor_image.empty() ? std::nullopt : std::optional(request);
    }
    const auto v = direction_from_angle(reader);
    reader.finish();
    if (!v)
      return std::nullopt;
    request.direction = *v;
    return request;
  }
  table.fault("fibre", wanted, describe(*node));
  return std::nullopt;
}

void fibres_from_tensors(const std::filesystem::path& file, const ImageInfo& labels, const Index3& coarsen,
                         const std::string& path, int line, FaultList& faults, Specimen& body) {
  const ImageInfo info = read_image_info(file);
  if (info.components != 6) {
    faults.add(line, path, "a tensor image with 6 values a voxel: xx yy zz xy xz yz",
               fmt::format("{} a voxel", info.components));
    return;
  }
  if (!same_voxels(info, labels)) {
    faults.add(line, path, "a tensor image on the voxels of the labels, " + words(labels), words(info));
    return;
  }
  const Image image = read_image(file);
  const auto n = static_cast<std::size_t>(body.grid.n_cells());
  body.fibres.assign(n, {0, 0, 0});
  std::vector<Tensor> mean(256, Tensor::Zero());
  std::vector<std::size_t> without;
  for (std::size_t cell = 0; cell < n; ++cell) {
    if (body.material_id[cell] == no_material)
      continue;
    Index3 first = body.grid.cell_at(static_cast<std::int64_t>(cell));
    for (std::size_t a = 0; a < 3; ++a)
      first[a] *= coarsen[a];
    const Tensor tensor = block_tensor(image, first, coarsen);
    mean[body.material_id[cell]] += tensor;
    if (const auto direction = principal_direction(tensor))
      body.fibres[cell] = *direction;
    else
      without.push_back(cell);
  }
  // Voxels in which no direction stands out take the one of their material's mean tensor.
  for (const std::size_t cell : without)
    body.fibres[cell] =
        principal_direction(mean[body.material_id[cell]]).value_or(std::array<float, 3>{1, 0, 0});
}

} // namespace maille::reader
