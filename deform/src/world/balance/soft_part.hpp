#pragma once
/// Displacements of a body's nodes in its frame, under the forces of contacts.
///
/// displacement = unloaded + response to the contact forces, once rounds have converged. `unloaded` is what
/// handles, holds and inertia make of the body alone. A component has the number dimension * node + axis, of
/// the body's nodes in the order of its grid.
///
/// A body that nothing holds, or that stands elsewhere than its frame, *floats*: only its rigid motion is
/// taken away, its RigidPart moves it, and what holds and handles want of it are contacts that may pull.
///
/// *Local*: rounds move the nodes that are near something (watch); catch_up() moves the rest after them.

#include "world/surface/flexibility.hpp"
#include "world/surface/skin.hpp"
#include "world/world_objects.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

struct Response;

class SoftPart {
public:
  SoftPart(const DeformableObject& body, const Skin& skin);

  const Eigen::VectorXd& displacement() const { return state_.displacement; }
  /// Displacement of the node that a component is of; 0 along z in two dimensions.
  Eigen::Vector3d displacement_at(std::int64_t first) const {
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    u.head(dimension_) = state_.displacement.segment(first, dimension_);
    return u;
  }
  void set_displacement(Eigen::VectorXd displacement) { state_.displacement = std::move(displacement); }
  /// Components of a node of the skin begin with this.
  std::int64_t first(std::int32_t node) const { return first_[node]; }
  /// True if the scene's holds have a node of the skin, along an axis of the frame or all.
  bool is_held(std::int32_t node, int axis) const { return (held_[node] >> axis & 1) != 0; }
  bool is_held(std::int32_t node) const { return held_[node] == (1 << dimension_) - 1; }

  /// What holds and handles have now. @return whether the body responds differently from now on
  bool hold(bool is_elsewhere, int threads);
  bool floats() const { return floats_; }
  /// True if time passes and it is on its way to where it would fly to.
  bool is_carried() const { return carried_.size() > 0; }
  /// @param inertia  mass of every component over the square of a step of time [N/m]
  void set_inertia(Eigen::VectorXd inertia);
  /// @param carried  inertia times where every component would fly to [N]
  void set_carried(const Eigen::VectorXd& where) { carried_ = inertia_.cwiseProduct(where); }
  void forget_stiffness() { flexibility_.reset(); }
  /// Where handles and inertia have the body without contacts. @return how far that has changed [m]
  double prescribe();

  /// Components that holds and handles keep while the body floats, with the forces that do.
  const std::vector<std::int64_t>& pulled() const { return pulled_; }
  void set_pull(Eigen::VectorXd forces) { state_.pull = std::move(forces); }
  /// Force of a hand or a hold on a component, along the axes of the first frame [N].
  double pull_at(std::int64_t component) const;

  Flexibility& flexibility() { return *flexibility_; }
  /// From where a component is to where it would be without contacts [m].
  double missing(std::int64_t component) const {
    return state_.unloaded[component] - state_.displacement[component];
  }
  /// Displacement of moved() for forces on components.
  Eigen::VectorXd answer(const std::vector<std::pair<std::int64_t, double>>& forces);
  /// From where the moved nodes are to a displacement of them.
  Eigen::VectorXd way_to(const Eigen::VectorXd& displacement) const;
  /// The same for one node that is moved. @param first  of its components
  Eigen::VectorXd way_at(std::int64_t first, const Eigen::VectorXd& displacement) const;
  /// Product of the way of the last round with this one's.
  double onwards(const Eigen::VectorXd& displacement);
  const Eigen::VectorXd& way() const { return way_; }
  /// Moves nodes and the forces that they are in balance with by a part of a response.
  void go(const Response& response, double part);

  /// Nodes of the body that rounds move, sorted; nodes of the skin among them.
  const std::vector<std::int32_t>& watched() const { return watched_; }
  /// @return whether other nodes are moved than before
  bool watch(std::vector<std::int32_t> nodes_of_skin);
  void watch_all();
  /// Moves all nodes to where the forces of contacts have them. @return by how much, at most [m]
  double catch_up();

  double energy() const { return flexibility_ ? flexibility_->energy(state_.displacement) : 0; }

  /// What rounds change.
  struct State {
    Eigen::VectorXd displacement, unloaded; ///< in the body's frame [m]
    Eigen::VectorXd contact_forces;         ///< in its frame [N]
    std::vector<std::int64_t> forced;       ///< components with contact forces, sorted
    Eigen::VectorXd pull;                   ///< on pulled components, along the axes of the first frame [N]
  };
  const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }

private:
  const DeformableObject* body_;
  int dimension_;
  std::vector<std::int64_t> first_; ///< by node of the skin
  std::vector<char> held_;          ///< by node of the skin, one bit an axis of the frame
  std::unique_ptr<Flexibility> flexibility_;
  std::vector<std::int64_t> fixed_; ///< components that the flexibility has held, sorted
  std::vector<std::int64_t> kept_;  ///< components that holds and handles have, sorted
  bool is_kept_ = false;            ///< those allow no rigid motion
  bool floats_ = false;
  std::vector<std::int64_t> pulled_;
  Eigen::VectorXd inertia_, carried_;
  State state_;
  std::vector<std::int32_t> watched_, moved_; ///< nodes of the skin; of the body, with those of pulled_
  std::vector<std::int32_t> place_of_;        ///< of a node of the body among moved_; -1: none
  Eigen::VectorXd way_;                       ///< that the last round asked for [m]
};

} // namespace maille::deform
