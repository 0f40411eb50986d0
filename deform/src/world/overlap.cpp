/// Detection of overlapping objects from their geometry only, without the map.

#include "lattice/tolerances.hpp"
#include "world/cell_overlap.hpp"
#include "world/engine.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace maille::deform {

namespace {

using Box = Eigen::AlignedBox3d;

/// Multilinear weights of the corners of a cell at a place in it, x fastest.
double weight_of(std::size_t corner, const Eigen::Vector3d& place, int dimension) {
  double weight = 1;
  for (int a = 0; a < dimension; ++a)
    weight *= (corner >> a & 1) != 0 ? place[a] : 1 - place[a];
  return weight;
}

/// True if a point is in a deformed hexahedron (quadrilateral, segment): finds its place in the undeformed
/// one by Newton's method. An inverted cell contains no point. Independent of the map's code.
bool does_hexahedron_hold(const std::vector<Eigen::Vector3d>& corners, const Eigen::Vector3d& point,
                          int dimension) {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  place.head(dimension).setConstant(0.5);
  for (int iteration = 0; iteration < iteration_cap; ++iteration) {
    Eigen::Vector3d rest = -point;
    Eigen::Matrix3d slope = Eigen::Matrix3d::Zero();
    for (std::size_t corner = 0; corner < corners.size(); ++corner) {
      rest += weight_of(corner, place, dimension) * corners[corner];
      for (int a = 0; a < dimension; ++a) {
        double rate = (corner >> a & 1) != 0 ? 1 : -1;
        for (int b = 0; b < dimension; ++b)
          if (b != a)
            rate *= (corner >> b & 1) != 0 ? place[b] : 1 - place[b];
        slope.col(a) += rate * corners[corner];
      }
    }
    for (int a = dimension; a < 3; ++a) {
      slope(a, a) = 1;
      rest[a] = 0;
    }
    if (!(slope.determinant() > 0))
      return false;
    const Eigen::Vector3d step = slope.inverse() * rest;
    place = (place - step).cwiseMax(-1).cwiseMin(2); // stay near the cell: the mapping may fold outside
    if (step.cwiseAbs().maxCoeff() < rounding)
      break;
  }
  for (int a = 0; a < dimension; ++a)
    if (place[a] < -tolerance || place[a] > 1 + tolerance)
      return false;
  return true;
}

/// Geometry of an object: boxes of a lattice at a pose, or cells with displaced corners.
class Matter {
public:
  explicit Matter(int dimension) : dimension_(dimension) {}
  virtual ~Matter() = default;
  virtual bool holds(const Eigen::Vector3d& point) const = 0;
  /// Calls visit(point) for points of each cell, until it returns true. @return number of cells where it did
  virtual std::int64_t count_cells(const std::function<bool(const Eigen::Vector3d&)>& visit) const = 0;
  const Box& box() const { return box_; }
  /// True if a point and points at a distance around it are inside.
  bool holds_deep(const Eigen::Vector3d& point, double distance) const {
    if (!holds(point))
      return false;
    const int n = dimension_ == 1 ? 3 : dimension_ == 2 ? 9 : 27;
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d way(i % 3 - 1, i / 3 % 3 - (n > 3), n > 9 ? i / 9 - 1 : 0);
      if (!way.isZero(0) && !holds(point + distance * way.normalized()))
        return false;
    }
    return true;
  }

protected:
  /// Sample points in a cell of matter, in [0, 1] along each axis: as dense as cells of the world, and half a
  /// diagonal from its faces, or in its middle. Cells of the world closer to its faces may belong to other
  /// objects.
  std::vector<Eigen::Vector3d> places_within(const Vec3& length, const Vec3& cell_size) const {
    double diagonal = 0;
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimension_); ++a)
      diagonal = std::hypot(diagonal, cell_size[a]);
    std::array<std::vector<double>, 3> along{{{0.5}, {0.5}, {0.5}}};
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimension_); ++a) {
      const double inner = 1 - diagonal / length[a];
      const int n = static_cast<int>(std::ceil(inner * length[a] / cell_size[a] - 1e-9));
      if (n > 0)
        along[a].clear();
      for (int i = 0; n > 0 && i <= n; ++i)
        along[a].push_back(0.5 + inner * (static_cast<double>(i) / n - 0.5));
    }
    std::vector<Eigen::Vector3d> places;
    for (const double z : along[2])
      for (const double y : along[1])
        for (const double x : along[0])
          places.emplace_back(x, y, z);
    return places;
  }

  int dimension_;
  Box box_;
};

class RigidMatter : public Matter {
public:
  RigidMatter(const RigidShape& shape, const Pose& pose, const Vec3& cell_size, int dimension)
      : Matter(dimension), shape_(shape), pose_(pose), places_(places_within(shape.spacing(), cell_size)) {
    const Index3& size = shape.size();
    is_matter_.assign(std::int64_t{1} * size[0] * size[1] * size[2], false);
    for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel)
      is_matter_[number(shape.index_of(voxel))] = true;
    for (int corner = 0; corner < 8; ++corner)
      box_.extend(
          at(Eigen::Vector3d((corner & 1) * size[0], (corner >> 1 & 1) * size[1], (corner >> 2) * size[2])));
  }
  bool holds(const Eigen::Vector3d& point) const override {
    const Eigen::Vector3d within = pose_.rotation.transpose() * (point - pose_.position);
    Index3 index;
    for (std::size_t a = 0; a < 3; ++a) {
      const double i = std::floor(within[static_cast<Eigen::Index>(a)] / shape_.spacing()[a]);
      if (!(i >= 0 && i < shape_.size()[a]))
        return false;
      index[a] = static_cast<int>(i);
    }
    return is_matter_[number(index)];
  }
  std::int64_t count_cells(const std::function<bool(const Eigen::Vector3d&)>& visit) const override {
    std::int64_t n = 0;
    for (std::int32_t voxel = 0; voxel < shape_.n_voxels(); ++voxel) {
      const Index3 i = shape_.index_of(voxel);
      n += std::ranges::any_of(places_, [&](const Eigen::Vector3d& place) {
        return visit(at(Eigen::Vector3d(i[0], i[1], i[2]) + place));
      });
    }
    return n;
  }

private:
  std::size_t number(const Index3& i) const {
    return static_cast<std::size_t>(i[0] +
                                    shape_.size()[0] * (i[1] + std::int64_t{1} * shape_.size()[1] * i[2]));
  }
  Eigen::Vector3d at(const Eigen::Vector3d& index) const {
    return pose_.position +
           pose_.rotation * index.cwiseProduct(Eigen::Vector3d::Map(shape_.spacing().data()));
  }

  const RigidShape& shape_;
  const Pose& pose_;
  std::vector<bool> is_matter_;
  std::vector<Eigen::Vector3d> places_;
};

class SoftMatter : public Matter {
public:
  SoftMatter(const DeformableObject& body, int dimension)
      : Matter(dimension), body_(body),
        places_(places_within(body.scene().specimen.grid.spacing(), body.lattice().cell_size())) {
    for (std::int32_t voxel = 0; voxel < body.lattice().n_voxels(); ++voxel) {
      at_.push_back(body.lattice().position(voxel, body.displacement()));
      box_.extend(at_.back());
    }
    for (std::int32_t cell = 0; cell < body.matter().n_cells(); ++cell) {
      Box& box = boxes_.emplace_back();
      for (const std::int32_t node : body.matter().corners(cell))
        box.extend(at_[node]);
      widest_ = std::max(widest_, box.sizes()[0]);
      by_left_.push_back(cell);
    }
    std::ranges::sort(by_left_, {}, [&](std::int32_t cell) { return left(cell); });
  }
  bool holds(const Eigen::Vector3d& point) const override {
    if (!is_near(box_, point))
      return false;
    const auto first = std::ranges::lower_bound(by_left_, point[0] - widest_, {},
                                                [&](std::int32_t cell) { return left(cell); });
    for (auto cell = first; cell != by_left_.end() && left(*cell) <= point[0]; ++cell)
      if (is_near(boxes_[*cell], point) && does_hexahedron_hold(corners(*cell), point, dimension_))
        return true;
    return false;
  }
  std::int64_t count_cells(const std::function<bool(const Eigen::Vector3d&)>& visit) const override {
    std::int64_t n = 0;
    for (std::int32_t cell = 0; cell < body_.matter().n_cells(); ++cell) {
      const std::vector<Eigen::Vector3d> at = corners(cell);
      n += std::ranges::any_of(places_, [&](const Eigen::Vector3d& place) {
        Eigen::Vector3d x = Eigen::Vector3d::Zero();
        for (std::size_t corner = 0; corner < at.size(); ++corner)
          x += weight_of(corner, place, dimension_) * at[corner];
        return visit(x);
      });
    }
    return n;
  }

private:
  double left(std::int32_t cell) const { return boxes_[cell].min()[0]; }
  bool is_near(const Box& box, const Eigen::Vector3d& point) const {
    for (int a = 0; a < dimension_; ++a)
      if (point[a] < box.min()[a] || point[a] > box.max()[a])
        return false;
    return true;
  }
  std::vector<Eigen::Vector3d> corners(std::int32_t cell) const {
    std::vector<Eigen::Vector3d> list;
    for (const std::int32_t node : body_.matter().corners(cell))
      list.push_back(at_[node]);
    return list;
  }

  const DeformableObject& body_;
  std::vector<Eigen::Vector3d> places_, at_;
  std::vector<Box> boxes_;
  std::vector<std::int32_t> by_left_; ///< cells in the order of their lowest x
  double widest_ = 0;
};

/// True if two axis-aligned boxes intersect.
bool do_meet(const Box& a, const Box& b, int dimension) {
  for (int axis = 0; axis < dimension; ++axis)
    if (a.min()[axis] > b.max()[axis] || b.min()[axis] > a.max()[axis])
      return false;
  return true;
}

} // namespace

std::int64_t World::n_penetrations() const {
  if (scene().is_open)
    return 0;
  const int dimension = scene().dimension;
  double diagonal = 0;
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a)
    diagonal = std::hypot(diagonal, cell_size()[a]);
  std::vector<std::unique_ptr<Matter>> matter;
  for (int object = 0; object < n_objects(); ++object)
    if (engine_->world().is_body(object))
      matter.push_back(std::make_unique<SoftMatter>(engine_->world().body(object), dimension));
    else
      matter.push_back(std::make_unique<RigidMatter>(shape(object), pose(object), cell_size(), dimension));
  const auto is_out = [&](const Eigen::Vector3d& x) {
    for (int a = 0; a < dimension; ++a) {
      const auto i = static_cast<std::size_t>(a);
      if (x[a] < -0.5 * diagonal || x[a] > map().cells()[i] * cell_size()[i] + 0.5 * diagonal)
        return true;
    }
    return false;
  };
  std::int64_t n = 0;
  const auto may_be_thin = [&](int object) { // too thin for sample points
    const WorldObject& what = scene().objects[object];
    return scene().contact == ContactLaw::surfaces && !engine_->world().is_body(object) && !what.is_smooth;
  };
  for (int i = 0; i < n_objects(); ++i)
    for (int j = 0; j < i && may_be_thin(i); ++j)
      n += may_be_thin(j) &&
           is_matter_in(scene().objects[i].scene.specimen, pose(i), scene().objects[j].scene.specimen,
                        pose(j), 0.5 * *std::ranges::min_element(cell_size()));
  for (const auto& one : matter) {
    std::vector<const Matter*> near;
    for (const auto& other : matter)
      if (other != one && do_meet(one->box(), other->box(), dimension))
        near.push_back(other.get());
    if (near.empty() && !is_out(one->box().min()) && !is_out(one->box().max()))
      continue;
    n += one->count_cells([&](const Eigen::Vector3d& x) {
      return is_out(x) || std::ranges::any_of(near, [&](const Matter* other) {
               return other->holds_deep(x, 0.5 * diagonal);
             });
    });
  }
  return n;
}

} // namespace maille::deform
