#include "conditions/anatomy.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace maille::reader {

namespace {

struct PatientDirection {
  std::string_view name;
  Vec3 ras;
};
constexpr std::array<PatientDirection, 8> patient_directions{{{"superior", {0, 0, 1}},
                                                              {"inferior", {0, 0, -1}},
                                                              {"left", {-1, 0, 0}},
                                                              {"right", {1, 0, 0}},
                                                              {"anterior", {0, 1, 0}},
                                                              {"posterior", {0, -1, 0}},
                                                              {"proximal", {0, 0, 1}},
                                                              {"distal", {0, 0, -1}}}};

const PatientDirection* patient_direction(std::string_view name) {
  const auto* found = std::ranges::find(patient_directions, name, &PatientDirection::name);
  return found == patient_directions.end() ? nullptr : found;
}

RegionFault unknown_patient(const Specimen& body) {
  return {"an image that says where a patient's right, front and head are (NIfTI with an sform or a qform, "
          "MetaImage with AnatomicalOrientation), or places in frame = \"grid\" or \"world\"",
          body.shape == "image" ? "an image that does not" : "a body of shape " + body.shape};
}

/// The largest piece of the cells that is connected through faces; the first among equals.
std::vector<std::int64_t> largest_piece(const std::vector<std::int64_t>& cells, const Grid& grid) {
  std::set<std::int64_t> left(cells.begin(), cells.end());
  std::vector<std::int64_t> largest;
  while (!left.empty()) {
    std::vector<std::int64_t> piece{*left.begin()};
    left.erase(left.begin());
    for (std::size_t next = 0; next < piece.size(); ++next) {
      const Index3 at = grid.cell_at(piece[next]);
      for (int side = 0; side < 2 * grid.dimension(); ++side) {
        Index3 beside = at;
        beside[side / 2] += side % 2 ? 1 : -1;
        if (grid.has_cell(beside) && left.erase(grid.cell(beside)))
          piece.push_back(grid.cell(beside));
      }
    }
    if (piece.size() > largest.size())
      largest = std::move(piece);
  }
  return largest;
}

Eigen::Vector3d middle_of(const Specimen& body, std::int64_t cell) {
  const Vec3 low = body.position(body.grid.cell_at(cell));
  Eigen::Vector3d middle(low[0], low[1], low[2]);
  for (int a = 0; a < body.grid.dimension(); ++a)
    middle[a] += body.grid.spacing()[a] / 2;
  return middle;
}

/// The variance of cells along their principal axes, smallest first [m^2], and the axes.
Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal_axes(const std::vector<std::int64_t>& cells,
                                                              const Specimen& body) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const std::int64_t cell : cells)
    mean += middle_of(body, cell);
  mean /= static_cast<double>(cells.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const std::int64_t cell : cells) {
    const Eigen::Vector3d from_mean = middle_of(body, cell) - mean;
    spread += from_mean * from_mean.transpose();
  }
  // Includes the variance within a cell: otherwise a row of two cells would be infinitely slender.
  spread /= static_cast<double>(cells.size());
  for (int a = 0; a < body.grid.dimension(); ++a)
    spread(a, a) += std::pow(body.grid.spacing()[a], 2) / 12;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread);
}

} // namespace

OrFault<Placement> placement_in(const Specimen& body, CoordinateFrame frame) {
  if (frame == CoordinateFrame::grid)
    return Placement{};
  if (frame == CoordinateFrame::world)
    return body.placement;
  if (body.placement.world == WorldAxes::unknown)
    return unknown_patient(body);
  Placement placement = body.placement;
  const WorldAxes wanted = frame == CoordinateFrame::ras ? WorldAxes::ras : WorldAxes::lps;
  if (placement.world != wanted)
    for (std::size_t row = 0; row < 2; ++row) {
      placement.origin[row] = -placement.origin[row];
      for (double& component : placement.direction[row])
        component = -component;
    }
  placement.world = wanted;
  return placement;
}

bool is_direction(std::string_view name) {
  return patient_direction(name) || Region::face(name, 0);
}

OrFault<Vec3> direction_named(std::string_view name, const Specimen& body) {
  const PatientDirection* direction = patient_direction(name);
  if (!direction) {
    Vec3 along{};
    along[name[0] - 'x'] = name[1] == '+' ? 1 : -1;
    return along;
  }
  const auto placement = placement_in(body, CoordinateFrame::ras);
  if (const auto* fault = std::get_if<RegionFault>(&placement))
    return *fault;
  Placement turned = std::get<Placement>(placement);
  turned.origin = {};
  return point_in_object(turned, direction->ras);
}

OrFault<std::string> face_towards(std::string_view direction, const Specimen& body) {
  const auto towards = direction_named(direction, body);
  if (const auto* fault = std::get_if<RegionFault>(&towards))
    return *fault;
  const Vec3& along = std::get<Vec3>(towards);
  std::size_t nearest = 0;
  for (std::size_t a = 1; a < static_cast<std::size_t>(body.grid.dimension()); ++a)
    if (std::abs(along[a]) > std::abs(along[nearest]))
      nearest = a;
  return std::string{"xyz"[nearest], along[nearest] > 0 ? '+' : '-'};
}

OrFault<std::vector<std::int64_t>> cells_of_label(std::int64_t label, const Specimen& body) {
  std::vector<std::int64_t> cells;
  std::set<std::int32_t> known;
  for (std::size_t cell = 0; cell < body.label.size(); ++cell) {
    if (!body.is_matter(static_cast<std::int64_t>(cell)))
      continue;
    known.insert(body.label[cell]);
    if (body.label[cell] == label)
      cells.push_back(static_cast<std::int64_t>(cell));
  }
  if (!cells.empty())
    return cells;
  if (known.empty())
    return RegionFault{"a body from an image with `labels`, up to 255 whole grey values",
                       fmt::format("{}, in a body that has none", label)};
  return RegionFault{fmt::format("a label of the body: {}", fmt::join(known, ", ")),
                     fmt::format("{}, which no cell of it has", label)};
}

OrFault<Region> end_of_label(const std::vector<std::int64_t>& cells, std::string_view direction, double depth,
                             const Specimen& body) {
  // Below this slenderness, noise at the border of a label rotates the axis; across the direction, ends are
  // sides.
  constexpr double least_slenderness = 1.2, least_cosine = 0.5;
  const auto towards = direction_named(direction, body);
  if (const auto* fault = std::get_if<RegionFault>(&towards))
    return *fault;
  const Vec3& t = std::get<Vec3>(towards);
  const auto piece = largest_piece(cells, body.grid);
  const auto axes = principal_axes(piece, body);
  const double slenderness = std::sqrt(axes.eigenvalues()[2] / axes.eigenvalues()[1]);
  if (!(slenderness >= least_slenderness))
    return RegionFault{"a label that is longer than thick: its spread along its long axis at least "
                       "1.2 times that across",
                       fmt::format("{:.2f} times", slenderness)};
  Eigen::Vector3d along = axes.eigenvectors().col(2);
  double cosine = along.dot(Eigen::Vector3d(t[0], t[1], t[2]));
  if (cosine < 0) {
    along = -along;
    cosine = -cosine;
  }
  if (cosine < least_cosine)
    return RegionFault{
        "an end of the label's long axis, which is along " +
            fmt::format("({:.2f}, {:.2f}, {:.2f}) of the grid", along[0], along[1], along[2]),
        fmt::format("\"{}\", {:.0f} degrees off it", direction, std::acos(cosine) * 180 / std::numbers::pi)};
  const auto height = [&](std::int64_t node) {
    const Vec3 x = body.position(body.grid.node_at(node));
    return along.dot(Eigen::Vector3d(x[0], x[1], x[2]));
  };
  double top = -INFINITY;
  for (const std::int64_t cell : piece)
    for (int corner = 0; corner < body.grid.corners_per_cell(); ++corner)
      top = std::max(top, height(body.grid.corner(body.grid.cell_at(cell), corner)));
  const double lowest = top - depth - place_tolerance(body);
  std::vector<std::int64_t> nodes;
  for (const std::int64_t cell : cells)
    for (int corner = 0; corner < body.grid.corners_per_cell(); ++corner)
      if (const std::int64_t node = body.grid.corner(body.grid.cell_at(cell), corner); height(node) >= lowest)
        nodes.push_back(node);
  std::vector<Region> both;
  both.push_back(Region::of_cells(body.grid, cells));
  both.push_back(Region::numbered(std::move(nodes)));
  return Region::all(std::move(both));
}

} // namespace maille::reader
