#include "maille/scene/block_frames.hpp"

#include <algorithm>

namespace maille {

namespace {

/// Difference of displacement along an edge [m].
Eigen::Vector3d difference(const Displacement& u, std::int64_t tail, std::int64_t head) {
  Eigen::Vector3d d = Eigen::Vector3d::Zero();
  for (std::size_t b = 0; b < u.n_components(); ++b)
    d[static_cast<Eigen::Index>(b)] = u(b, head) - u(b, tail);
  return d;
}

} // namespace

Eigen::Matrix3d displacement_gradient(const Grid& grid, const Displacement& u, const Index3& cell) {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
  const int d = grid.dimension();
  const double share = 2.0 / grid.corners_per_cell();
  for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
    const std::int64_t node = grid.corner(cell, corner);
    for (int axis = 0; axis < d; ++axis) {
      const double weight = (corner >> axis & 1 ? share : -share) / grid.spacing()[axis];
      for (int b = 0; b < d; ++b)
        gradient(b, axis) += weight * u(b, node);
    }
  }
  return gradient;
}

Eigen::Matrix3d as_stress(const Vector6& v) {
  Eigen::Matrix3d S;
  S << v[0], v[5], v[4], v[5], v[1], v[3], v[4], v[3], v[2];
  return S;
}

Eigen::Matrix3d as_strain(const Vector6& v) {
  Vector6 halves = v;
  halves.tail<3>() /= 2;
  return as_stress(halves);
}

Vector6 stress_of(const Eigen::Matrix3d& S) {
  Vector6 v;
  v << S(0, 0), S(1, 1), S(2, 2), S(1, 2), S(0, 2), S(0, 1);
  return v;
}

Vector6 strain_of(const Eigen::Matrix3d& A) {
  return stress_of(A + A.transpose()).cwiseProduct((Vector6() << 0.5, 0.5, 0.5, 1, 1, 1).finished());
}

namespace {

/// Without free strains.
LawResponse respond(const CellMatter& matter, const Eigen::Matrix3d& E, double& active) {
  LawResponse response = matter.material.law ? respond(*matter.material.law, E, matter.fibre)
                                             : respond_corotated(matter.stiffness, E);
  active = 0;
  if (matter.tension != 0) {
    const double stretch = std::sqrt(1 + 2 * matter.fibre.dot(E * matter.fibre));
    const Vector6 along = stress_of(matter.fibre * matter.fibre.transpose());
    active = matter.tension * (stretch - 1);
    response.stress += matter.tension / stretch * along;
    response.tangent -= matter.tension / std::pow(stretch, 3) * along * along.transpose();
  }
  return response;
}

/// Limit of iterations for free strains; five or six reach rounding level.
constexpr int most_steps = 40;
/// Smallest fraction of a Newton step in the line search.
constexpr double shortest = 1e-6;
/// Stress over stiffness that counts as zero [1].
constexpr double no_stress = 1e-13;

} // namespace

/// Newton iteration for minimum energy over the free strains; steps are halved until the energy falls.
LawResponse respond(const CellMatter& matter, int dimension, PlaneAssumption plane, Eigen::Matrix3d& E,
                    double& active) {
  LawResponse response = respond(matter, E, active);
  if (dimension == 3 || (dimension == 2 && plane == PlaneAssumption::strain))
    return response;
  const std::vector<int> free = dimension == 1 ? std::vector{1, 2, 3, 4, 5} : std::vector{2, 3, 4};
  Vector6 strain = strain_of(E);
  for (int i = 0; i < most_steps; ++i) {
    const Eigen::VectorXd pull = response.stress(free);
    const Eigen::MatrixXd stiffness = response.tangent(free, free);
    const double largest = stiffness.diagonal().cwiseAbs().maxCoeff();
    if (pull.cwiseAbs().maxCoeff() <= no_stress * largest)
      break;
    Eigen::VectorXd step = -stiffness.ldlt().solve(pull);
    if (!(step.dot(pull) < 0)) // the energy is not convex here
      step = -pull / largest;
    const double before = response.energy + active;
    for (double length = 1; length > shortest; length /= 2) {
      Vector6 next = strain;
      next(free) += length * step;
      E = as_strain(next);
      if ((Eigen::Matrix3d::Identity() + 2 * E).llt().info() != Eigen::Success)
        continue;
      response = respond(matter, E, active);
      if (response.energy + active <= before + length * 1e-4 * step.dot(pull) + 1e-15 * std::abs(before)) {
        strain = next;
        break;
      }
    }
  }
  E = as_strain(strain);
  const Eigen::MatrixXd beside = response.tangent(Eigen::all, free), stiffness = response.tangent(free, free);
  response.tangent -= beside * stiffness.ldlt().solve(beside.transpose());
  for (const int p : free)
    response.stress[p] = 0;
  return response;
}

List<Eigen::Quaterniond> block_rotations(const Scene& scene, const Displacement& displacement) {
  const Grid& grid = scene.specimen.grid;
  List<Eigen::Quaterniond> rotation(static_cast<std::size_t>(grid.n_cells()), Eigen::Quaterniond::Identity());
  if (scene.dimension() == 1)
    return rotation;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      rotation[cell] = nearest_rotation(scene.dimension(),
                                        Eigen::Matrix3d::Identity() +
                                            displacement_gradient(grid, displacement, grid.cell_at(cell)),
                                        Eigen::Quaterniond::Identity());
  return rotation;
}

double largest_violation_in_blocks(const Scene& scene, const LinkLimits& limits,
                                   const Displacement& displacement) {
  const Grid& grid = scene.specimen.grid;
  const List<Eigen::Quaterniond> rotation = block_rotations(scene, displacement);
  double largest = 0;
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    const double rest = grid.spacing()[axis];
    const Eigen::Vector3d at_rest = rest * Eigen::Vector3d::Unit(axis);
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      if (at[axis] + 1 >= grid.nodes()[axis])
        continue;
      const auto link = limits.intervals(at, axis);
      if (!link)
        continue;
      const Eigen::Vector3d now = at_rest + difference(displacement, node, node + grid.stride(axis));
      MeanRotation mean;
      scene.specimen.for_each_cell_at_link(at, axis, [&](std::int64_t cell) { mean.add(rotation[cell]); });
      const Eigen::Vector3d change = mean.value().conjugate() * now - at_rest;
      for (int b = 0; b < grid.dimension(); ++b) {
        const auto i = static_cast<std::size_t>(b);
        largest = std::max({largest, (link->low[i] - change[b]) / rest, (change[b] - link->high[i]) / rest});
      }
    }
  }
  return largest;
}

} // namespace maille
