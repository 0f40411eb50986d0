#include "maille/mechanics/friction.hpp"

#include "maille/scene/plausibility.hpp"

#include <Eigen/QR>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

namespace maille {

namespace {

/// Give up after this many rounds.
constexpr int most_rounds = 600;
/// Rounds that acceleration combines. After as many, slipping contacts are asked whether anything holds them.
constexpr int most_kept = 10;
/// Over-relaxation: factor on the change of a round (Eckstein & Bertsekas 1992).
constexpr double over_relaxation = 1.6;

Eigen::Vector3d of(const Vec3& v) {
  return {v[0], v[1], v[2]};
}
Vec3 of(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

/// Slip of the first node relative to the second, along the border.
Eigen::Vector3d slip_of(const NodeTie& tie, const Eigen::Vector3d& apart) {
  const Eigen::Vector3d n = of(tie.normal);
  return apart - n * n.dot(apart);
}
Eigen::Vector3d slip_of(const NodeTie& tie, const Displacement& u) {
  return slip_of(tie, of(u.at(tie.one)) - of(u.at(tie.other)));
}

} // namespace

bool has_friction(const NodeTies& tied) {
  return std::ranges::any_of(tied.ties, [](const NodeTie& tie) { return tie.friction > 0; });
}

Vec3 rub_of(const NodeTie& tie, const Vec3& apart) {
  if (tie.spring == 0)
    return tie.pull;
  return of(Eigen::Vector3d(of(tie.pull) - tie.spring * slip_of(tie, of(apart))));
}
Vec3 rub_of(const NodeTie& tie, const Displacement& u) {
  return rub_of(tie, of(Eigen::Vector3d(of(u.at(tie.one)) - of(u.at(tie.other)))));
}

std::vector<double> press_of_ties(const Scene& split, const Displacement& forces) {
  const NodeTies& tied = split.tied;
  const Grid& grid = split.specimen.grid;
  std::set<std::pair<std::int64_t, int>> prescribed;
  for (const Prescribed& p : split.prescribed)
    prescribed.insert({p.node, p.component});
  const auto place_of = [&](std::int64_t node) {
    Index3 at = grid.node_at(node);
    at[2] %= tied.planes;
    return at;
  };
  std::vector<double> press(tied.ties.size(), 0);
  for (std::size_t first = 0, end = 0; first < tied.ties.size(); first = end) {
    while (end < tied.ties.size() && place_of(tied.ties[end].one) == place_of(tied.ties[first].one))
      ++end;
    std::map<std::int64_t, Eigen::Index> row_of; // of the nodes at this place
    std::vector<std::pair<std::size_t, Eigen::Vector3d>> columns;
    for (std::size_t t = first; t < end; ++t) {
      for (const std::int64_t node : {tied.ties[t].one, tied.ties[t].other})
        row_of.try_emplace(node, 3 * static_cast<Eigen::Index>(row_of.size()));
      if (const Eigen::Vector3d n = of(tied.ties[t].normal); !n.isZero(0))
        columns.emplace_back(t, n);
      else
        for (int b = 0; b < 3; ++b)
          columns.emplace_back(t, Eigen::Vector3d::Unit(b));
    }
    Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(row_of.size()),
                                                       static_cast<Eigen::Index>(columns.size()));
    Eigen::VectorXd brought = Eigen::VectorXd::Zero(directions.rows());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const NodeTie& tie = tied.ties[columns[c].first];
      directions.col(static_cast<Eigen::Index>(c)).segment<3>(row_of.at(tie.one)) += columns[c].second;
      directions.col(static_cast<Eigen::Index>(c)).segment<3>(row_of.at(tie.other)) -= columns[c].second;
    }
    for (const auto& [node, row] : row_of)
      for (int b = 0; b < 3; ++b)
        if (prescribed.contains({node, b}))
          directions.row(row + b).setZero();
        else
          brought[row + b] = forces(b, node);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> least_squares;
    least_squares.setThreshold(1e-10);
    least_squares.compute(directions);
    const Eigen::VectorXd tension = least_squares.solve(brought);
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (tied.ties[columns[c].first].normal != Vec3{})
        press[columns[c].first] = -tension[static_cast<Eigen::Index>(c)];
  }
  return press;
}

Friction::Friction(const Scene& split) : split_(split), pulls_(split.tied.ties.size()) {
  for (std::size_t t = 0; t < pulls_.size(); ++t)
    if (split.tied.ties[t].friction > 0)
      contacts_.push_back({t, {}, {}, 0});
  state_ = Eigen::VectorXd::Zero(4 * static_cast<Eigen::Index>(contacts_.size()));
}

/// Sets a state and its split into sticking and slipping contacts: the tangential force [N] and the friction
/// bound [N] of every contact.
void Friction::take(const Eigen::VectorXd& state) {
  state_ = state;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact& contact = contacts_[i];
    const double spring = split_.tied.ties[contact.tie].spring;
    auto of_contact = state_.segment<4>(4 * static_cast<Eigen::Index>(i));
    of_contact[3] = std::max(0.0, of_contact[3]);
    const Eigen::Vector3d draws = of_contact.head<3>();
    const double size = draws.norm(), bound = of_contact[3];
    const Eigen::Vector3d drag = size > bound ? Eigen::Vector3d(bound / size * draws) : draws;
    const Eigen::Vector3d slip = (draws - drag) / spring;
    contact.slip = of(slip);
    contact.drag = of(drag);
    pulls_[contact.tie] = of(Eigen::Vector3d(spring * slip - drag));
  }
}

/// The new state from the answer of a round.
Eigen::VectorXd Friction::state_of(const Displacement& u, const std::vector<double>& press) {
  Eigen::VectorXd state(state_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    Contact& contact = contacts_[i];
    const NodeTie& tie = split_.tied.ties[contact.tie];
    contact.press = press[contact.tie];
    auto of_contact = state.segment<4>(4 * static_cast<Eigen::Index>(i));
    of_contact.head<3>() =
        tie.spring * (over_relaxation * slip_of(tie, u) + (1 - over_relaxation) * of(contact.slip)) +
        of(contact.drag);
    of_contact[3] = tie.friction * std::max(0.0, contact.press);
  }
  return state;
}

/// Anderson acceleration: the combination of the last rounds whose changes cancel best; restarts after
/// divergence.
Eigen::VectorXd Friction::accelerated(const Eigen::VectorXd& found) {
  constexpr double astray = 4; // times the least change so far
  const Eigen::VectorXd change = found - state_;
  const double size = change.norm();
  if (size > astray * least_change_) {
    found_.clear();
    changes_.clear();
    least_change_ = size;
  }
  least_change_ = std::min(least_change_, size);
  found_.push_back(found);
  changes_.push_back(change);
  if (std::ssize(found_) > most_kept) {
    found_.erase(found_.begin());
    changes_.erase(changes_.begin());
  }
  const auto n = static_cast<Eigen::Index>(found_.size()) - 1;
  if (n == 0)
    return found;
  Eigen::MatrixXd of_changes(change.size(), n), of_found(change.size(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    of_changes.col(k) = changes_[static_cast<std::size_t>(k) + 1] - changes_[k];
    of_found.col(k) = found_[static_cast<std::size_t>(k) + 1] - found_[k];
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> least_squares;
  least_squares.setThreshold(1e-6);
  least_squares.compute(of_changes);
  return found - of_found * least_squares.solve(change);
}

/// Rigid motion of a label without friction at slipping contacts; empty: the sticking contacts prevent any.
std::string Friction::slipping_motion() const {
  Scene slipping = split_;
  bool any = false;
  for (const Contact& contact : contacts_)
    if (contact.slip != Vec3{}) {
      slipping.tied.ties[contact.tie].friction = 0;
      any = true;
    }
  return any ? remaining_rigid_motion(slipping) : std::string{};
}

bool Friction::fails(const std::string& motion) {
  double most = 0;
  for (const RubbingBorder& border : borders())
    most += border.rubbed;
  status_ = Status::failed;
  message_ =
      motion.empty()
          ? fmt::format(
                "friction did not settle in {} rounds: contacts keep changing between sticking and slipping",
                rounds_)
          : fmt::format("{}: friction, {:.4g} N at most, does not hold what pulls there", motion, most);
  return false;
}

bool Friction::needs_another_round(const Displacement& u, const std::vector<double>& press) {
  if (contacts_.empty())
    return false;
  constexpr int doubts_in_a_row = 4; // a single one may be transient
  const double tolerance = std::clamp(split_.relaxation.tolerance, 1e-8, 1e-4);
  const Eigen::VectorXd found = state_of(u, press);
  double presses = 0, pulls = 0;
  for (const Contact& contact : contacts_) {
    presses = std::max(presses, contact.press);
    pulls = std::max(pulls, -contact.press);
  }
  // Without pressed contacts, slips may be rounding relative to the forces across the border.
  const double scale = presses > 0 ? found.norm() : std::max(found.norm(), pulls);
  if ((found - state_).norm() <= tolerance * scale) {
    take(found);
    for (const RubbingBorder& border : borders())
      if (border.pressed == 0)
        message_ += fmt::format("{}nothing presses labels {} and {} together: friction has no effect there",
                                message_.empty() ? "" : "; ", border.one, border.other);
    const std::string motion = slipping_motion(); // converged by chance, or changes only small relatively
    return !motion.empty() && fails(motion);
  }
  take(accelerated(found));
  if (++rounds_ % most_kept == 0) {
    const std::string motion = slipping_motion();
    doubts_ = motion.empty() ? 0 : doubts_ + 1;
    if (doubts_ == doubts_in_a_row)
      return fails(motion);
  }
  return rounds_ < most_rounds || fails({});
}

std::vector<RubbingBorder> Friction::borders() const {
  std::map<std::pair<std::int32_t, std::int32_t>, RubbingBorder> all;
  std::map<std::pair<std::int32_t, std::int32_t>, int> n;
  for (const Contact& contact : contacts_) {
    const std::array<std::int32_t, 2>& label = split_.tied.ties[contact.tie].label;
    RubbingBorder& border = all[{label[0], label[1]}];
    border.one = label[0];
    border.other = label[1];
    border.pressed += std::max(0.0, contact.press);
    border.rubbed += of(contact.drag).norm();
    border.slipping += contact.slip != Vec3{} ? 1 : 0;
    ++n[{label[0], label[1]}];
  }
  std::vector<RubbingBorder> list;
  for (auto& [labels, border] : all) {
    border.slipping /= n.at(labels);
    list.push_back(border);
  }
  return list;
}

} // namespace maille
