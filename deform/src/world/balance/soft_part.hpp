#pragma once
/// Displacements of a body's nodes in its frame, under the forces of contacts.
///
/// displacement = unloaded + response to the contact forces, once rounds have converged. `unloaded` follows
/// from handles, holds and inertia without contacts. Component `axis` of a body's node has the number
/// dimension * node + axis; nodes are in the order of its grid.
///
/// A body without holds, or outside its initial frame, *floats*: its RigidPart moves it, `fixed_` only
/// removes its rigid motions, and holds and handles become contacts that may pull.
/// *Local*: rounds move only nodes near other surfaces (watch); catch_up() moves the rest afterwards.

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
  /// Displacement of the node with this first component; 0 along z in two dimensions.
  Eigen::Vector3d displacement_at(std::int64_t first) const {
    Eigen::Vector3d u = Eigen::Vector3d::Zero();
    u.head(dimension_) = state_.displacement.segment(first, dimension_);
    return u;
  }
  void set_displacement(Eigen::VectorXd displacement) { state_.displacement = std::move(displacement); }
  /// First component of a node of the skin.
  std::int64_t first(std::int32_t node) const { return first_[node]; }
  /// True if the scene holds a node of the skin, along an axis of the frame or along all.
  bool is_held(std::int32_t node, int axis) const { return (held_[node] >> axis & 1) != 0; }
  bool is_held(std::int32_t node) const { return held_[node] == (1 << dimension_) - 1; }

  /// Updates holds and handles. @return true if the stiffness of the body changes
  bool hold(bool is_elsewhere, int threads);
  bool floats() const { return floats_; }
  /// True if the body has inertia and a free-flight target.
  bool is_carried() const { return carried_.size() > 0; }
  /// @param inertia  mass of every component over the square of a time step [N/m]
  void set_inertia(Eigen::VectorXd inertia);
  /// @param where  target of free flight for every component [m]
  void set_carried(const Eigen::VectorXd& where) { carried_ = inertia_.cwiseProduct(where); }
  void forget_stiffness() { flexibility_.reset(); }
  void prepare() { flexibility_->prepare(); }
  void forget_unused() { flexibility_->forget_unused(); }
  /// Updates the displacement without contacts. @return its largest change [m]
  double prescribe();

  /// Components of holds and handles while the body floats.
  const std::vector<std::int64_t>& pulled() const { return pulled_; }
  void set_pull(Eigen::VectorXd forces) { state_.pull = std::move(forces); }
  /// Force of a drive or a hold on a component, along the axes of the initial frame [N].
  double pull_at(std::int64_t component) const;

  /// @param components  sorted
  const Eigen::MatrixXd& compliance(const std::vector<std::int64_t>& components) {
    return flexibility_->compliance(components);
  }
  /// Difference of the displacement without contacts and the present one [m].
  double missing(std::int64_t component) const {
    return state_.unloaded[component] - state_.displacement[component];
  }
  /// Displacement of moved() for forces on components.
  Eigen::VectorXd answer(const std::vector<std::pair<std::int64_t, double>>& forces);
  /// Difference of a displacement of the moved nodes and the present one.
  Eigen::VectorXd way_to(const Eigen::VectorXd& displacement) const;
  /// The same for one moved node. @param first  its first component
  Eigen::VectorXd way_at(std::int64_t first, const Eigen::VectorXd& displacement) const;
  /// Dot product of the steps of the last round and this one; stores this one.
  double dot_with_last_step(const Eigen::VectorXd& displacement);
  const Eigen::VectorXd& way() const { return way_; }
  /// Moves nodes and their contact forces by a part of a response.
  void go(const Response& response, double part);

  /// Nodes of the skin that rounds move, sorted.
  const std::vector<std::int32_t>& watched() const { return watched_; }
  /// @return true if the set of moved nodes changes
  bool watch(std::vector<std::int32_t> nodes_of_skin);
  void watch_all();
  /// Moves all nodes to their response to the contact forces. @return true if the body was local
  bool catch_up();

  double energy() const { return flexibility_ ? flexibility_->energy(state_.displacement) : 0; }

  /// The part of the state that rounds change.
  struct State {
    Eigen::VectorXd displacement, unloaded; ///< in the body's frame [m]
    Eigen::VectorXd contact_forces;         ///< in its frame [N]
    std::vector<std::int64_t> forced;       ///< components with contact forces, sorted
    Eigen::VectorXd pull;                   ///< on pulled components, along the axes of the initial frame [N]
  };
  const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }

private:
  const DeformableObject* body_;
  int dimension_;
  std::vector<std::int64_t> first_; ///< by node of the skin
  std::vector<char> held_;          ///< by node of the skin, one bit per axis of the frame
  std::unique_ptr<Flexibility> flexibility_;
  std::vector<std::int64_t> fixed_; ///< fixed components of the flexibility, sorted
  std::vector<std::int64_t> kept_;  ///< components of holds and handles, sorted
  bool is_kept_ = false;            ///< kept_ removes all rigid motions
  bool floats_ = false;
  std::vector<std::int64_t> pulled_;
  Eigen::VectorXd inertia_, carried_;
  State state_;
  std::vector<std::int32_t> watched_, moved_; ///< nodes of the skin; of the body, with those of pulled_
  std::vector<std::int32_t> place_of_;        ///< index among moved_, by node of the body; -1: none
  Eigen::VectorXd way_;                       ///< full step of the last round [m]
};

} // namespace maille::deform
