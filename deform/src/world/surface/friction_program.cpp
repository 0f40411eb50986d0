#include "world/surface/friction_program.hpp"

#include "lattice/tolerances.hpp"
#include "world/surface/contact_program.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace maille::deform {

namespace {

enum class State : char { open, sticks, slips };

class FrictionProgram {
public:
  FrictionProgram(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                  const std::vector<char>& may_pull, std::span<const FrictionRows> contacts, double friction)
      : compliance_(compliance), gap0_(gap0), may_pull_(may_pull), contacts_(contacts), friction_(friction),
        is_tangent_(static_cast<std::size_t>(gap0.size()), 0), states_(contacts.size(), State::open),
        along_(contacts.size(), Eigen::Vector2d::Zero()) {
    for (const FrictionRows& rows : contacts)
      for (int k = 0; k < rows.n; ++k)
        is_tangent_[rows.first + k] = 1;
  }

  Eigen::VectorXd run(std::vector<char>& active) {
    // Initial active set: contacts without friction.
    std::vector<Eigen::Index> plain;
    std::vector<char> pull, set;
    for (Eigen::Index i = 0; i < gap0_.size(); ++i)
      if (!is_tangent_[i]) {
        plain.push_back(i);
        pull.push_back(may_pull_[i]);
        set.push_back(active[i]);
      }
    const Eigen::VectorXd begin = contact_forces(compliance_(plain, plain), gap0_(plain), pull, set);
    active_.assign(active.size(), 0);
    for (std::size_t i = 0; i < plain.size(); ++i)
      active_[plain[i]] = set[i];
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      states_[i] = presses(contacts_[i]) ? State::sticks : State::open;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(gap0_.size());
    force(plain) = begin;
    bool has_settled = settle(force);
    if (!has_settled) {
      sweep(force);
      guess(force);
      Eigen::VectorXd better = force;
      has_settled = settle(better);
      if (has_settled)
        force = better;
    }
    active = active_;
    for (Eigen::Index i = 0; i < force.size(); ++i)
      if (!is_tangent_[i] && may_pull_[i] == 0)
        force[i] = std::max(0.0, force[i]);
    limit(force);
    return force;
  }

private:
  bool presses(const FrictionRows& rows) const { return active_[rows.normal] != 0; }

  /// Forces of the active contacts, for the present states of sticking and slipping.
  Eigen::VectorXd forces() const {
    std::vector<Eigen::Index> rows;
    Eigen::MatrixXd columns = compliance_; // a normal force includes its slip force
    for (Eigen::Index i = 0; i < gap0_.size(); ++i)
      if (active_[i] != 0)
        rows.push_back(i);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const FrictionRows& contact = contacts_[i];
      for (int k = 0; k < contact.n; ++k) {
        if (states_[i] == State::sticks)
          rows.push_back(contact.first + k);
        if (states_[i] == State::slips)
          columns.col(contact.normal) += friction_ * along_[i][k] * compliance_.col(contact.first + k);
      }
    }
    Eigen::VectorXd force = Eigen::VectorXd::Zero(gap0_.size());
    if (rows.empty())
      return force;
    const Eigen::MatrixXd matrix = columns(rows, rows);
    const Eigen::VectorXd missing = -gap0_(rows);
    const Eigen::VectorXd found = matrix.partialPivLu().solve(missing);
    force(rows) = found;
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (states_[i] == State::slips)
        for (int k = 0; k < contacts_[i].n; ++k)
          force[contacts_[i].first + k] = friction_ * along_[i][k] * force[contacts_[i].normal];
    return force;
  }

  /// @return true if all states are consistent with the forces
  bool settle(Eigen::VectorXd& force) {
    std::size_t fewest = active_.size() + contacts_.size() + 1;
    int left = patience;
    for (int round = 0; round < iteration_cap; ++round) {
      force = forces();
      std::vector<std::size_t> wrong = wrong_in(force);
      if (wrong.empty())
        return true;
      if (wrong.size() < fewest) {
        fewest = wrong.size();
        left = patience;
      } else if (--left <= 0) {
        wrong = {wrong[static_cast<std::size_t>(round) % wrong.size()]};
      }
      for (const std::size_t i : wrong)
        if (i < active_.size())
          active_[i] = active_[i] == 0;
        else
          states_[i - active_.size()] = next_[i - active_.size()];
      for (std::size_t i = 0; i < contacts_.size(); ++i)
        if (!presses(contacts_[i]))
          states_[i] = State::open;
        else if (states_[i] == State::open)
          states_[i] = State::sticks;
    }
    return false;
  }

  /// Normal rows, then contacts, whose state is not consistent with the forces; next_ receives the consistent
  /// states.
  std::vector<std::size_t> wrong_in(const Eigen::VectorXd& force) {
    const Eigen::VectorXd gap = gap0_ + compliance_ * force;
    const double least_force = rounding * force.cwiseAbs().maxCoeff(),
                 least_gap = rounding * gap0_.cwiseAbs().maxCoeff();
    std::vector<std::size_t> wrong;
    for (Eigen::Index i = 0; i < gap0_.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (is_tangent_[k] || may_pull_[k] != 0)
        continue;
      if (active_[k] != 0 ? force[i] < -least_force : gap[i] < -least_gap)
        wrong.push_back(k);
    }
    next_ = states_;
    for (std::size_t i = 0; i < contacts_.size(); ++i)
      if (is_wrong(i, force, gap, least_gap))
        wrong.push_back(active_.size() + i);
    return wrong;
  }

  bool is_wrong(std::size_t i, const Eigen::VectorXd& force, const Eigen::VectorXd& gap, double least_gap) {
    const FrictionRows& rows = contacts_[i];
    Eigen::Vector2d along = Eigen::Vector2d::Zero(), slip = along;
    along.head(rows.n) = force.segment(rows.first, rows.n);
    slip.head(rows.n) = gap.segment(rows.first, rows.n);
    if (states_[i] == State::slips) {
      if (slip.dot(along_[i]) > least_gap) { // friction opposes slip; else the contact sticks
        next_[i] = State::sticks;
        return true;
      }
      if (rows.n == 2 && slip.norm() > least_gap) {
        const Eigen::Vector2d against = -slip.normalized();
        const bool has_turned = (against - along_[i]).norm() > tolerance;
        along_[i] = against;
        return has_turned;
      }
      return false;
    }
    if (states_[i] == State::sticks &&
        along.norm() > friction_ * std::max(0.0, force[rows.normal]) * (1 + tolerance) + 1e-300) {
      next_[i] = State::slips;
      along_[i] = along.normalized();
      return true;
    }
    return false;
  }

  /// Gauss-Seidel over contacts: slow, but it converges where Newton's method cycles.
  void sweep(Eigen::VectorXd& force) const {
    for (Eigen::Index i = 0; i < force.size(); ++i)
      if (!is_tangent_[i] && may_pull_[i] == 0)
        force[i] = std::max(0.0, force[i]);
    limit(force);
    Eigen::VectorXd gap = gap0_ + compliance_ * force;
    const auto give = [&](Eigen::Index row, double to) {
      const double change = to - force[row];
      if (change != 0)
        gap += change * compliance_.col(row);
      force[row] = to;
      return std::abs(change);
    };
    for (int turn = 0; turn < iteration_cap; ++turn) {
      double largest = 0;
      for (Eigen::Index i = 0; i < force.size(); ++i) {
        if (is_tangent_[i])
          continue;
        const double to = force[i] - gap[i] / compliance_(i, i);
        largest = std::max(largest, give(i, may_pull_[i] != 0 ? to : std::max(0.0, to)));
      }
      for (const FrictionRows& rows : contacts_) {
        const double give_way = compliance_.diagonal().segment(rows.first, rows.n).maxCoeff(),
                     most = friction_ * force[rows.normal];
        Eigen::VectorXd to = force.segment(rows.first, rows.n) - gap.segment(rows.first, rows.n) / give_way;
        if (to.norm() > most)
          to *= most / to.norm();
        for (int k = 0; k < rows.n; ++k)
          largest = std::max(largest, give(rows.first + k, to[k]));
      }
      if (largest <= 1e-13 * force.cwiseAbs().maxCoeff())
        break;
    }
  }

  /// Sets the states from the forces.
  void guess(const Eigen::VectorXd& force) {
    const double least = 1e-10 * force.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < force.size(); ++i)
      if (const auto k = static_cast<std::size_t>(i); !is_tangent_[k])
        active_[k] = may_pull_[k] != 0 || force[i] > least;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const FrictionRows& rows = contacts_[i];
      const auto rub = force.segment(rows.first, rows.n);
      states_[i] = !presses(rows)                                             ? State::open
                   : rub.norm() < friction_ * force[rows.normal] * (1 - 1e-7) ? State::sticks
                                                                              : State::slips;
      along_[i].setZero();
      if (rub.norm() > 0)
        along_[i].head(rows.n) = rub.normalized();
    }
  }

  /// Limits tangential forces to the friction bound.
  void limit(Eigen::VectorXd& force) const {
    for (const FrictionRows& rows : contacts_) {
      const double most = friction_ * force[rows.normal], size = force.segment(rows.first, rows.n).norm();
      if (size > most)
        force.segment(rows.first, rows.n) *= most / size;
    }
  }

  const Eigen::MatrixXd& compliance_;
  const Eigen::VectorXd& gap0_;
  const std::vector<char>& may_pull_;
  std::span<const FrictionRows> contacts_;
  double friction_;
  std::vector<char> is_tangent_, active_;
  std::vector<State> states_, next_;
  std::vector<Eigen::Vector2d> along_; ///< direction of friction of slipping contacts
};

} // namespace

Eigen::VectorXd frictional_forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                                  const std::vector<char>& may_pull, std::vector<char>& active,
                                  std::span<const FrictionRows> contacts, double friction) {
  active.resize(gap0.size(), 0);
  return FrictionProgram(compliance, gap0, may_pull, contacts, friction).run(active);
}

} // namespace maille::deform
