#pragma once
/// Sliding borders with Coulomb friction: forces of ties, and friction between their nodes.

#include "maille/scene/answer.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace maille {

/// True if any tie has friction.
bool has_friction(const NodeTies& tied);

/// Force of the spring of a tie and of NodeTie::pull on its first node; opposite on the second [N].
Vec3 rub_of(const NodeTie& tie, const Displacement& u);
/// @param apart  displacement of the first node relative to the second [m]
Vec3 rub_of(const NodeTie& tie, const Vec3& apart);

/// Computes Answer::tie_press.
/// @param split   of split_borders()
/// @param forces  of ties on nodes: K u less loads, and less rub_of() of every tie [N]
/// A tie whose components are all prescribed contributes nothing.
/// Cost  O(ties)
std::vector<double> press_of_ties(const Scene& split, const Displacement& forces);

/// Coulomb friction of a question. Nodes on a border stick while the tangential force is less than the
/// coefficient times the normal force, and slip against that bound beyond it, as under a load that grows
/// proportionally from rest. Under tension across a border there is no friction.
///
/// Alternating directions: springs between copies of nodes, whose rest lengths and pulls are iterated. Every
/// round is a linear question for the same operator, so that factors and hierarchies are reused.
///
/// Source  Glowinski & Le Tallec 1989, Augmented Lagrangian and Operator-Splitting Methods, ch. 3;
///         Walker & Ni 2011, Anderson acceleration for fixed-point iterations
/// Checked by  tests/support/conditions_test.cpp
class Friction {
public:
  /// @param split  of split_borders(); outlives it
  explicit Friction(const Scene& split);

  bool empty() const { return contacts_.empty(); }
  /// Values of NodeTie::pull for the next round, by tie [N].
  const std::vector<Vec3>& pulls() const { return pulls_; }
  /// Updates the state from the answer of a round. @return true if another round is needed
  /// @param press of press_of_ties()
  bool needs_another_round(const Displacement& u, const std::vector<double>& press);
  /// done; or failed: friction does not hold a pulled part, or rounds do not converge.
  Status status() const { return status_; }
  const std::string& message() const { return message_; }
  /// Sums over the borders in the last round.
  std::vector<RubbingBorder> borders() const;

private:
  struct Contact {
    std::size_t tie = 0;
    Vec3 slip{};      ///< of the first node relative to the second; rest length of the spring [m]
    Vec3 drag{};      ///< friction force on the second node; opposite on the first [N]
    double press = 0; ///< [N]
  };
  void take(const Eigen::VectorXd& state);
  Eigen::VectorXd state_of(const Displacement& u, const std::vector<double>& press);
  Eigen::VectorXd accelerated(const Eigen::VectorXd& found);
  std::string slipping_motion() const;
  bool fails(const std::string& motion);

  const Scene& split_;
  std::vector<Contact> contacts_;
  std::vector<Vec3> pulls_;
  Status status_ = Status::done;
  std::string message_;
  int rounds_ = 0, doubts_ = 0;
  Eigen::VectorXd state_;                        ///< four numbers per contact, see take()
  std::vector<Eigen::VectorXd> found_, changes_; ///< of the last rounds
  double least_change_ = std::numeric_limits<double>::infinity();
};

} // namespace maille
