#pragma once
/// Borders that slide with Coulomb's friction: forces of ties, and what rubs between their nodes.

#include "maille/scene/answer.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace maille {

/// Whether any tie rubs.
bool has_friction(const NodeTies& tied);

/// What the spring of a tie and NodeTie::pull exert on its first node, the opposite on the second [N].
Vec3 rub_of(const NodeTie& tie, const Displacement& u);
/// @param apart  how far the first node has gone from the second [m]
Vec3 rub_of(const NodeTie& tie, const Vec3& apart);

/// Answer::tie_press.
/// @param split   of split_borders()
/// @param forces  what ties bring to nodes: K u less loads, and less rub_of() of every tie [N]
/// Where all components that a tie joins are prescribed it brings nothing.
/// Cost  O(ties)
std::vector<double> press_of_ties(const Scene& split, const Displacement& forces);

/// Coulomb's friction of a question: along a border nodes stick while what holds them is less than the
/// coefficient times what presses them together, and slip against that force beyond it, as under a load that
/// grows from rest in proportion. What pulls a border open rubs nothing.
///
/// Alternating directions: springs between copies of nodes, whose rest lengths and pulls are found in rounds;
/// every round is one linear question of one operator, so that factors and hierarchies serve all of them.
///
/// Source  Glowinski & Le Tallec 1989, Augmented Lagrangian and Operator-Splitting Methods, ch. 3;
///         Walker & Ni 2011, Anderson acceleration for fixed-point iterations
/// Checked by  tests/deform/elastic/friction_test.cpp, tests/fem_ref/friction_test.cpp
class Friction {
public:
  /// @param split  of split_borders(); outlives it
  explicit Friction(const Scene& split);

  bool empty() const { return contacts_.empty(); }
  /// Values of NodeTie::pull for the next round, by tie [N].
  const std::vector<Vec3>& pulls() const { return pulls_; }
  /// Takes the answer of a round. @return true if another is needed
  /// @param press of press_of_ties()
  bool goes_on(const Displacement& u, const std::vector<double>& press);
  /// Done; or failed: a pulled part is not fixed, or rounds do not converge.
  Status status() const { return status_; }
  const std::string& message() const { return message_; }
  /// Sums over the borders, as the last round has them.
  std::vector<RubbingBorder> borders() const;

private:
  struct Contact {
    std::size_t tie = 0;
    Vec3 slip{};      ///< of the first node against the second, at which the spring is at rest [m]
    Vec3 drag{};      ///< of friction: on the second node, its opposite on the first [N]
    double press = 0; ///< [N]
  };
  void take(const Eigen::VectorXd& state);
  Eigen::VectorXd state_of(const Displacement& u, const std::vector<double>& press);
  Eigen::VectorXd accelerated(const Eigen::VectorXd& found);
  std::string motion_of_what_slips() const;
  bool fails(const std::string& motion);

  const Scene& split_;
  std::vector<Contact> contacts_;
  std::vector<Vec3> pulls_;
  Status status_ = Status::done;
  std::string message_;
  int rounds_ = 0, doubts_ = 0;
  Eigen::VectorXd state_;                        ///< four numbers a contact, see take()
  std::vector<Eigen::VectorXd> found_, changes_; ///< of the last rounds
  double least_change_ = std::numeric_limits<double>::infinity();
};

} // namespace maille
