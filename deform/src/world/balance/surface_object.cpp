#include "world/balance/surface_object.hpp"

#include "lattice/tolerances.hpp"
#include "world/surface/smooth_surface.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// A free object is in equilibrium if the resultant of its forces and moments is at most `in_balance` of the
/// sum of their magnitudes, its motion is less than a step, and the motion repeats that of the last round
/// within `steady` [1]. Larger values end rounds too early; smaller ones let an object drift.
constexpr double in_balance = 1e-5, steady = 0.1;

} // namespace

double RigidPart::distance_to_target(const Pose& pose) const {
  if (!target)
    return 0;
  const Eigen::AngleAxisd turn(target->rotation * pose.rotation.transpose());
  return (target->position - pose.position).norm() + std::abs(turn.angle()) * radius_;
}

Matrix6 RigidPart::compliance(double drag) const {
  if (inertia_)
    return inertia_->inverse();
  Vector6 diagonal;
  const double stiffness = is_free() ? drag_stiffness_ * drag : stiffness_;
  diagonal.head<3>().setConstant(1 / stiffness);
  diagonal.tail<3>().setConstant(1 / (stiffness * radius_ * radius_));
  return diagonal.asDiagonal();
}

Vector6 RigidPart::wanted(const Pose& pose) const {
  Vector6 motion = Vector6::Zero();
  if (!target)
    return motion;
  const Eigen::Matrix3d rotation = target->rotation * pose.rotation.transpose();
  const Eigen::Vector3d middle = target->position + rotation * (middle_ - pose.position);
  const Eigen::AngleAxisd turn(rotation);
  motion << middle - middle_, turn.angle() * turn.axis();
  return motion;
}

Vector6 RigidPart::way_of(const Vector6& motion) const {
  Vector6 way = motion;
  way.tail<3>() *= radius_;
  return way;
}

bool RigidPart::only_drifts(const Vector6& motion, double drag, double step, bool has_gone) {
  if (!is_free())
    return false;
  const Vector6 way = way_of(motion);
  const double steadily = (way - std::exchange(drift_, way)).norm();
  return has_gone && steadily < steady * way.norm() && way.norm() < step &&
         drag_stiffness_ * drag * way.norm() < in_balance * sum_of_forces_;
}

double RigidPart::dot_with_last_step(const Vector6& motion) {
  const Vector6 way = way_of(motion);
  const double product = way_.dot(way);
  way_ = way;
  return product;
}

SurfaceObject::SurfaceObject(const WorldObjects& world, int object)
    : dimension(world.scene.dimension), kind(world.member(object).kind),
      skin(world.object(object).scene.specimen), specimen_(&world.object(object).scene.specimen) {
  const Grid& grid = specimen_->grid;
  for (std::int32_t node = 0; node < skin.n_nodes(); ++node)
    rest.push_back(rest_of(grid.node_at(skin.node(node))));
  if (world.is_body(object)) {
    lattice_ = &world.body(object).lattice();
    pose = lattice_->pose();
    soft.emplace(world.body(object), skin);
  } else {
    const int index = world.member(object).index;
    pose = world.rigid.pose(index);
    const RigidShape& shape = world.rigid.shape(index);
    std::vector<std::int32_t> by_cell(grid.n_cells(), -1);
    for (std::int32_t i = 0; i < shape.n_voxels(); ++i)
      by_cell[grid.cell(shape.index_of(i))] = i;
    std::ranges::copy_if(by_cell, std::back_inserter(voxel_), [](std::int32_t i) { return i >= 0; });
    if (world.object(object).is_smooth)
      make_smooth(*specimen_, rest);
    const PlacedSkin placed(skin, rest, rest, 0);
    for (std::int32_t node = 0; node < skin.n_nodes(); ++node)
      is_flat_.push_back(std::ranges::all_of(skin.faces_at(node), [&](std::int32_t face) {
        return placed.normal_of(face).dot(placed.normal_of(skin.faces_at(node).front())) > 1 - rounding;
      }));
  }
  place();
}

Eigen::Vector3d SurfaceObject::rest_of(const Index3& node) const {
  if (kind == ObjectKind::deformable)
    return Eigen::Vector3d::Map(specimen_->position(node).data());
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int a = 0; a < dimension; ++a)
    x[a] = node[a] * specimen_->grid.spacing()[a];
  return x;
}

bool SurfaceObject::is_held_along(std::int32_t node, const Eigen::Vector3d& direction) const {
  if (!is_body())
    return kind == ObjectKind::fixed;
  for (int a = 0; a < dimension; ++a)
    if (is_along(a, direction) && !soft->is_held(node, a))
      return false;
  return !rigid.moves();
}

std::int64_t SurfaceObject::voxel(std::int32_t node) const {
  return is_body() ? skin.node(node) : voxel_[skin.cell_at(node)];
}

void SurfaceObject::place(std::int32_t node) {
  const auto i = static_cast<std::size_t>(node);
  Eigen::Vector3d x = rest[i];
  if (is_body())
    x += soft->displacement_at(soft->first(node));
  at[i] = pose.position + pose.rotation * x;
}

void SurfaceObject::place() {
  at.resize(rest.size());
  box.setEmpty();
  for (std::int32_t node = 0; node < skin.n_nodes(); ++node) {
    place(node);
    box.extend(at[node]);
  }
  rigid.place(centre ? Eigen::Vector3d(pose.position + pose.rotation * *centre) : box.center(),
              0.5 * box.diagonal().norm());
}

void SurfaceObject::place_watched() {
  for (const std::int32_t node : soft->watched())
    place(node);
}

void SurfaceObject::turn_and_shift(const Vector6& by) {
  const Eigen::Vector3d turn = by.tail<3>();
  if (const double angle = turn.norm(); angle > 0) {
    RigidMotion motion;
    motion.angle = angle;
    motion.axis = turn / angle;
    motion.about = rigid.middle();
    pose = motion.moved(pose, 1);
  }
  pose.position += by.head<3>();
}

double SurfaceObject::furthest(const Response& response) const {
  double way = response.motion.head<3>().norm() + response.motion.tail<3>().norm() * rigid.radius();
  if (is_body())
    if (const Eigen::VectorXd own = soft->way_to(response.displacement); own.size() > 0)
      way += own.cwiseAbs().maxCoeff() * std::sqrt(dimension);
  return way;
}

std::vector<Eigen::Vector3d> SurfaceObject::corners(std::int32_t cell) {
  const Grid& grid = specimen_->grid;
  if (matter_.empty()) {
    for (std::int64_t i = 0; i < grid.n_cells(); ++i)
      if (specimen_->is_matter(i))
        matter_.push_back(i);
    skin_node_.assign(grid.n_nodes(), -1);
    for (std::int32_t node = 0; node < skin.n_nodes(); ++node)
      skin_node_[skin.node(node)] = node;
  }
  const Index3 low = grid.cell_at(matter_[cell]);
  std::vector<Eigen::Vector3d> corners;
  for (int corner = 0; corner < 1 << dimension; ++corner) {
    const Index3 node{low[0] + (corner & 1), low[1] + (corner >> 1 & 1), low[2] + (corner >> 2)};
    if (const std::int32_t known = skin_node_[grid.node(node)]; known >= 0) {
      corners.push_back(at[known]);
      continue;
    }
    Eigen::Vector3d x = rest_of(node);
    if (is_body())
      x += soft->displacement_at(std::int64_t{dimension} * lattice_->voxel(grid.node(node)));
    corners.emplace_back(pose.position + pose.rotation * x);
  }
  return corners;
}

} // namespace maille::deform
