/// Contact forces of one round of a balance.

#include "lattice/sort_uniquely.hpp"
#include "lattice/tolerances.hpp"
#include "world/balance/balance.hpp"
#include "world/surface/contact_program.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace maille::deform {

namespace {

/// Contact stiffness over that of the stiffest cell. The small compliance makes redundant contacts share a
/// force.
constexpr double contact_over_cell_stiffness = 1e7;

} // namespace

/// Appends a row: forces of 1 N along a direction on the touching node, and opposite forces on the other
/// skin.
void Balance::push_apart(const Touch& touch, const Eigen::Vector3d& along, int row, Program& program) const {
  const auto push = [&](int object, std::int32_t node, const Eigen::Vector3d& force) {
    const SurfaceObject& one = this->object(object);
    const auto i = static_cast<std::size_t>(node);
    program.pushes[object].push_back(
        {row, object, force, one.at[i], one.is_body() ? one.soft->first(node) : std::int64_t{-1}});
  };
  push(touch.object, touch.node, along);
  for (std::size_t i = 0; i < 4; ++i)
    if (touch.other >= 0 && touch.weights[i] > 0)
      push(touch.other, touch.nodes[i], -touch.weights[i] * along);
}

Balance::Program Balance::program() const {
  Program program;
  program.pushes.resize(objects_.size());
  std::vector<double> gap;
  for (const Touch& touch : touches_) {
    push_apart(touch, touch.normal, static_cast<int>(gap.size()), program);
    gap.push_back(touch.gap - skin_over_cell * cell_);
    program.may_pull.push_back(0);
    program.active.push_back(touch.force > 0);
  }
  for (int i = 0; i < world_.n_objects(); ++i) {
    const SurfaceObject& one = object(i);
    for (const std::int64_t component : one.soft ? one.soft->pulled() : std::vector<std::int64_t>()) {
      const PosedLattice& lattice = world_.body(i).lattice();
      const int axis = static_cast<int>(component % one.dimension);
      const auto voxel = static_cast<std::int32_t>(component / one.dimension);
      const Eigen::Vector3d rest =
          lattice.pose().rotation.transpose() * (lattice.rest(voxel) - lattice.pose().position);
      program.pushes[i].push_back(
          {static_cast<int>(gap.size()), i, lattice.pose().rotation.col(axis),
           one.pose.position + one.pose.rotation * (rest + one.soft->displacement_at(component - axis)),
           component - axis});
      gap.push_back(missed(i, component));
      program.may_pull.push_back(1);
      program.active.push_back(1);
    }
  }
  add_friction(program, gap);
  program.gap = Eigen::VectorXd::Map(gap.data(), static_cast<Eigen::Index>(gap.size()));
  return program;
}

/// The selected rows, with their compliance.
Balance::Program Balance::part_of(const Program& whole, const std::vector<char>& is_chosen) {
  Program part;
  std::vector<int> place(is_chosen.size(), -1);
  std::vector<Eigen::Index> rows;
  for (std::size_t row = 0; row < is_chosen.size(); ++row)
    if (is_chosen[row] != 0) {
      place[row] = static_cast<int>(rows.size());
      rows.push_back(static_cast<Eigen::Index>(row));
      part.may_pull.push_back(whole.may_pull[row]);
      part.active.push_back(whole.active[row]);
    }
  part.gap = whole.gap(rows);
  for (const std::vector<Push>& pushes : whole.pushes) {
    std::vector<Push>& own = part.pushes.emplace_back();
    for (Push push : pushes)
      if (const int row = place[push.row]; row >= 0) {
        push.row = row;
        own.push_back(push);
      }
  }
  for (FrictionRows rub : whole.rubs) {
    rub.normal = place[rub.normal];
    rub.first = place[rub.first];
    part.rubs.push_back(rub);
  }
  part.compliance = Eigen::MatrixXd::Zero(part.gap.size(), part.gap.size());
  part.compliance.diagonal().setConstant(1 / (contact_over_cell_stiffness * stiffness_));
  for (int i = 0; i < world_.n_objects(); ++i) {
    if (part.pushes[i].empty())
      continue;
    if (object(i).is_body())
      add_compliance_of_body(i, part);
    if (object(i).rigid.moves())
      add_compliance_as_a_whole(i, part);
  }
  return part;
}

/// Gaps after a full step of all objects.
Eigen::VectorXd Balance::gaps_after(const Program& program, const std::vector<Response>& responses) const {
  Eigen::VectorXd gaps = program.gap;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const SurfaceObject& one = objects_[i];
    const Eigen::Vector3d shift = responses[i].motion.head<3>(), turn = responses[i].motion.tail<3>();
    for (const Push& push : program.pushes[i]) {
      if (one.is_body())
        gaps[push.row] += (one.pose.rotation.transpose() * push.force)
                              .head(one.dimension)
                              .dot(one.soft->way_at(push.first_component, responses[i].displacement));
      if (one.rigid.moves())
        gaps[push.row] += shift.dot(push.force) + turn.dot((push.at - one.rigid.middle()).cross(push.force));
    }
  }
  return gaps;
}

void Balance::grip() {
  grips_.clear();
  if (world_.scene.friction == 0)
    return;
  find_touches();
  for (const Touch& touch : touches_)
    if (touch.force > 0)
      grips_.try_emplace(key_of(touch), grip_at(touch));
}

Balance::Grip Balance::grip_at(const Touch& touch) const {
  return {touch.nodes, touch.weights, object(touch.object).at[touch.node]};
}

Eigen::Vector3d Balance::place_of(const Touch& touch, const Grip& grip) const {
  if (touch.other < 0)
    return grip.place;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    if (grip.weights[i] > 0)
      place += grip.weights[i] * object(touch.other).at[grip.nodes[i]];
  return place;
}

/// Appends rows for friction: tangential displacement of each contact from its grip.
void Balance::add_friction(Program& program, std::vector<double>& gap) const {
  if (grips_.empty())
    return;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const Touch& touch = touches_[i];
    const auto grip = grips_.find(key_of(touch));
    if (grip == grips_.end())
      continue;
    FrictionRows rows{static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(gap.size()),
                      world_.scene.dimension - 1};
    std::array<Eigen::Vector3d, 2> tangents;
    tangents[0] = world_.scene.dimension == 2 ? Eigen::Vector3d(-touch.normal[1], touch.normal[0], 0)
                                              : touch.normal.unitOrthogonal();
    tangents[1] = touch.normal.cross(tangents[0]);
    const Eigen::Vector3d off = object(touch.object).at[touch.node] - place_of(touch, grip->second);
    for (int k = 0; k < rows.n; ++k) {
      const Eigen::Vector3d& tangent = tangents[k];
      push_apart(touch, tangent, static_cast<int>(gap.size()), program);
      gap.push_back(tangent.dot(off));
      program.may_pull.push_back(0);
      program.active.push_back(0);
    }
    program.rubs.push_back(rows);
    program.tangents.push_back(tangents);
  }
}

void Balance::add_compliance_of_body(int number, Program& program) {
  SurfaceObject& one = object(number);
  const auto& pushes = program.pushes[number];
  const int d = one.dimension;
  std::vector<std::int64_t> components; // with forces
  std::vector<Eigen::Index> rows;       // only contacts of this body
  for (const Push& push : pushes) {
    rows.push_back(push.row);
    for (int b = 0; b < d; ++b)
      if (one.is_along(b, push.force))
        components.push_back(push.first_component + b);
  }
  sort_uniquely(rows);
  sort_uniquely(components);
  const auto n = static_cast<Eigen::Index>(components.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (const Push& push : pushes) {
    const Eigen::Vector3d force = one.pose.rotation.transpose() * push.force;
    const auto row = std::ranges::lower_bound(rows, Eigen::Index{push.row}) - rows.begin();
    for (int b = 0; b < d; ++b) {
      if (!one.is_along(b, push.force))
        continue;
      const auto place = std::ranges::lower_bound(components, push.first_component + b);
      entries.emplace_back(static_cast<int>(row), static_cast<int>(place - components.begin()), force[b]);
    }
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> forces(static_cast<Eigen::Index>(rows.size()), n); // for 1 N
  forces.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd missing(n); // difference from the displacement without contacts
  for (Eigen::Index i = 0; i < n; ++i)
    missing[i] = one.soft->missing(components[i]);
  const Eigen::MatrixXd& compliance = one.soft->compliance(components);
  const Eigen::MatrixXd half = forces * compliance; // rows x components
  const Eigen::MatrixXd given_way = forces * half.transpose();
  program.compliance(rows, rows) += given_way;
  program.gap(rows) += forces * missing;
}

namespace {

/// Force and moment of a push about a point, in the order of a shift and a rotation.
Vector6 wrench(const Eigen::Vector3d& force, const Eigen::Vector3d& at, const Eigen::Vector3d& about) {
  Vector6 result;
  result << force, (at - about).cross(force);
  return result;
}

} // namespace

void Balance::add_compliance_as_a_whole(int number, Program& program) const {
  const SurfaceObject& one = object(number);
  Eigen::MatrixXd wrenches = Eigen::MatrixXd::Zero(program.gap.size(), 6);
  std::vector<Eigen::Index> rows;
  for (const Push& push : program.pushes[number]) {
    wrenches.row(push.row) += wrench(push.force, push.at, one.rigid.middle()).transpose();
    rows.push_back(push.row);
  }
  sort_uniquely(rows);
  const Eigen::MatrixXd own = wrenches(rows, Eigen::all);
  program.compliance(rows, rows) += own * one.rigid.compliance(drag_) * own.transpose();
  program.gap(rows) += own * one.rigid.wanted(one.pose);
}

Response Balance::response(int number, const Program& program, const Eigen::VectorXd& force) {
  SurfaceObject& one = object(number);
  Response response;
  const auto& pushes = program.pushes[number];
  if (one.is_body()) {
    std::map<std::int64_t, double> forces;
    for (const Push& push : pushes)
      for (int b = 0; b < one.dimension && force[push.row] != 0; ++b)
        if (one.is_along(b, push.force))
          forces[push.first_component + b] += force[push.row] * one.pose.rotation.col(b).dot(push.force);
    response.forces.assign(forces.begin(), forces.end());
    response.displacement = one.soft->answer(response.forces);
  }
  if (one.rigid.moves()) {
    Vector6 sum = Vector6::Zero();
    for (const Push& push : pushes)
      sum += force[push.row] * wrench(push.force, push.at, one.rigid.middle());
    sum = one.rigid.compliance(drag_) * sum;
    response.motion = one.rigid.wanted(one.pose) + sum;
  }
  return response;
}

std::vector<Response> Balance::responses() {
  Program asked = program();
  // Most near nodes are not in contact: only their gaps are needed, not their compliance.
  const std::size_t n = asked.active.size(), n_touches = touches_.size();
  std::vector<char> is_chosen(n, 1);
  for (std::size_t i = 0; i < n_touches; ++i)
    is_chosen[i] = asked.active[i];
  for (const FrictionRows& rub : asked.rubs)
    is_chosen[rub.normal] = 1;
  Eigen::VectorXd force = Eigen::VectorXd::Zero(asked.gap.size());
  std::vector<Response> responses;
  for (bool is_whole = false; !is_whole;) {
    Program part = part_of(asked, is_chosen);
    const Eigen::VectorXd of_part =
        part.rubs.empty() ? contact_forces(part.compliance, part.gap, part.may_pull, part.active)
                          : frictional_forces(part.compliance, part.gap, part.may_pull, part.active,
                                              part.rubs, world_.scene.friction);
    Eigen::Index next = 0;
    for (std::size_t row = 0; row < n; ++row)
      if (is_chosen[row] != 0) {
        asked.active[row] = part.active[next];
        force[static_cast<Eigen::Index>(row)] = of_part[next++];
      }
    responses.clear();
    for (int i = 0; i < world_.n_objects(); ++i)
      responses.push_back(response(i, asked, force));
    const Eigen::VectorXd gaps = gaps_after(asked, responses);
    const double least = n > 0 ? -rounding * asked.gap.cwiseAbs().maxCoeff() : 0;
    is_whole = true;
    for (std::size_t row = 0; row < n_touches; ++row)
      if (is_chosen[row] == 0 && gaps[static_cast<Eigen::Index>(row)] < least) {
        is_chosen[row] = asked.active[row] = 1;
        is_whole = false;
      }
  }
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    touches_[i].force = force[static_cast<Eigen::Index>(i)];
    touches_[i].rubbing.setZero();
  }
  for (std::size_t i = 0; i < asked.rubs.size(); ++i)
    for (int k = 0; k < asked.rubs[i].n; ++k)
      touches_[asked.rubs[i].normal].rubbing += force[asked.rubs[i].first + k] * asked.tangents[i][k];
  Eigen::Index row = static_cast<Eigen::Index>(touches_.size());
  for (SurfaceObject& one : objects_)
    if (one.soft) {
      const Eigen::Index n_pulled = std::ssize(one.soft->pulled());
      one.soft->set_pull(force.segment(row, n_pulled));
      row += n_pulled;
    }
  return responses;
}

} // namespace maille::deform
