#include "geometry/pieces.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/sliding.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace maille {
namespace {

/// A small vector space that linear conditions reduce step by step, starting from R^n. Stores an orthonormal
/// basis (columns).
class NullSpace {
public:
  explicit NullSpace(Eigen::Index n) : basis_(Eigen::MatrixXd::Identity(n, n)) {}

  Eigen::Index dimension() const { return basis_.cols(); }
  const Eigen::MatrixXd& basis() const { return basis_; }
  /// Restricts to vectors v with row . v = 0. A row that earlier ones imply to 1e-9 has no effect.
  /// @param row entries of order one before any cancellation, so that rows of rounding errors are
  ///        recognised
  void forbid(const Eigen::VectorXd& row);

private:
  Eigen::MatrixXd basis_;
};

void NullSpace::forbid(const Eigen::VectorXd& row) {
  const Eigen::Index k = basis_.cols();
  if (k == 0)
    return;
  Eigen::VectorXd v = basis_.transpose() * row;
  const double length = v.norm();
  if (length <= 1e-9)
    return;
  // The reflection of v to the last unit vector gives k - 1 columns on which the row vanishes.
  v /= length;
  const double sign = v[k - 1] > 0 ? 1.0 : -1.0; // away from cancellation
  v[k - 1] += sign;
  const Eigen::MatrixXd reflected = basis_ - (basis_ * v) * (v.transpose() * (2.0 / v.squaredNorm()));
  basis_ = reflected.leftCols(k - 1);
}

/// A sparse basis of the same space: reduced row echelon form, one vector per row, pivots in column order.
Eigen::MatrixXd echelon(const Eigen::MatrixXd& basis) {
  Eigen::MatrixXd rows = basis.transpose();
  Eigen::Index rank = 0;
  for (Eigen::Index column = 0; column < rows.cols() && rank < rows.rows(); ++column) {
    Eigen::Index pivot = 0;
    if (rows.col(column).tail(rows.rows() - rank).cwiseAbs().maxCoeff(&pivot) < 1e-8)
      continue;
    rows.row(rank).swap(rows.row(rank + pivot));
    rows.row(rank) /= rows(rank, column);
    for (Eigen::Index other = 0; other < rows.rows(); ++other)
      if (other != rank)
        rows.row(other) -= rows(other, column) * rows.row(rank);
    ++rank;
  }
  return rows.topRows(rank);
}

struct Piece : BodyPieces::Piece {
  NullSpace motions{0};
};

class Pieces {
public:
  explicit Pieces(const Scene& scene);
  void apply_conditions();
  void apply_springs();
  /// Borders with friction are treated as tied.
  void add_ties();
  void spread_through_joints();
  std::string motion_left();

private:
  std::vector<std::int32_t> pieces_at(std::int64_t node) const {
    return found_.at_node(scene_->specimen.grid.node_at(node));
  }
  Eigen::VectorXd row(const Piece& piece, std::int64_t node, int component) const;
  Eigen::VectorXd row_along(const Piece& piece, std::int64_t node, const Vec3& along) const;
  bool tie(std::int32_t from, std::int32_t to, std::int64_t node);
  struct Tie;
  bool hold(const Tie& tie, std::size_t free);
  std::string joint_motion_left(const std::vector<std::int32_t>& loose) const;
  std::string describe(std::size_t piece, const Eigen::MatrixXd& motions) const;

  const Scene* scene_;
  int d_;
  int n_motions_;
  BodyPieces found_;
  std::vector<Piece> pieces_;
  struct Joint {
    std::int64_t node;
    std::vector<std::int32_t> pieces;
  };
  std::vector<Joint> joints_; ///< nodes that two pieces or more share
  /// Two nodes of two pieces that are tied along one direction.
  struct Tie {
    std::array<std::int64_t, 2> node{};
    std::array<std::int32_t, 2> piece{};
    Vec3 along{};
  };
  std::vector<Tie> ties_;
};

Pieces::Pieces(const Scene& scene)
    : scene_(&scene), d_(scene.dimension()), n_motions_(d_ * (d_ + 1) / 2), found_(scene.specimen) {
  for (const BodyPieces::Piece& piece : found_.pieces())
    pieces_.push_back({piece, NullSpace(n_motions_)});
  for (const std::int64_t node : found_.shared_nodes())
    joints_.push_back({node, pieces_at(node)});
}

/// The displacement `component` at `node` as a linear form of the piece's motions: rotations first (so that
/// echelon form separates pure shifts), then shifts. Lengths are in half extents of the piece, so that both
/// are O(1).
Eigen::VectorXd Pieces::row(const Piece& piece, std::int64_t node, int component) const {
  const Grid& grid = scene_->specimen.grid;
  const Index3 at = grid.node_at(node);
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  double half_extent = 0;
  for (int a = 0; a < d_; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    r[a] = grid.spacing()[axis] * (at[axis] - 0.5 * (piece.lower[axis] + piece.upper[axis]));
    half_extent = std::max(half_extent, 0.5 * grid.spacing()[axis] * (piece.upper[axis] - piece.lower[axis]));
  }
  r /= half_extent;
  Eigen::VectorXd form = Eigen::VectorXd::Zero(n_motions_);
  const int turns = n_motions_ - d_;
  form[turns + component] = 1;
  if (d_ == 2)
    form[0] = component == 0 ? -r[1] : r[0];
  if (d_ == 3) { // (w x r)_c = w_(c+1) r_(c+2) - w_(c+2) r_(c+1)
    const int next = (component + 1) % 3, last = (component + 2) % 3;
    form[next] = r[last];
    form[last] = -r[next];
  }
  return form;
}

void Pieces::apply_conditions() {
  for (const Prescribed& p : scene_->prescribed) {
    if (pieces_.size() == 1 && pieces_[0].motions.dimension() == 0)
      return; // the usual case: a few nodes are enough
    for (const std::int32_t label : pieces_at(p.node)) {
      Piece& piece = pieces_[label];
      if (piece.motions.dimension() > 0)
        piece.motions.forbid(row(piece, p.node, p.component));
    }
  }
}

void Pieces::apply_springs() {
  for (const NodalSpring& spring : nodal_springs(*scene_)) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> along(spring.stiffness);
    for (int k = 0; k < 3; ++k) {
      if (!(along.eigenvalues()[k] > 1e-9 * along.eigenvalues()[2]))
        continue;
      for (const std::int32_t label : pieces_at(spring.node)) {
        Piece& piece = pieces_[label];
        Eigen::VectorXd form = Eigen::VectorXd::Zero(n_motions_);
        for (int c = 0; c < d_; ++c)
          form += along.eigenvectors()(c, k) * row(piece, spring.node, c);
        piece.motions.forbid(form);
      }
    }
  }
}

Eigen::VectorXd Pieces::row_along(const Piece& piece, std::int64_t node, const Vec3& along) const {
  Eigen::VectorXd form = Eigen::VectorXd::Zero(n_motions_);
  for (int c = 0; c < d_; ++c)
    form += along[c] * row(piece, node, c);
  return form;
}

void Pieces::add_ties() {
  for (const NodeTie& tie : scene_->tied.ties)
    for (const std::int32_t one : pieces_at(tie.one))
      for (const std::int32_t other : pieces_at(tie.other))
        if (tie.normal != Vec3{} && tie.friction == 0)
          ties_.push_back({{tie.one, tie.other}, {one, other}, tie.normal});
        else
          for (std::size_t c = 0; c < 3; ++c) {
            ties_.push_back({{tie.one, tie.other}, {one, other}, {}});
            ties_.back().along[c] = 1;
          }
}

/// Removes the motions that a tie to a fixed piece prevents. True if there were any.
bool Pieces::hold(const Tie& tie, std::size_t free) {
  Piece& held = pieces_[tie.piece[free]];
  if (pieces_[tie.piece[1 - free]].motions.dimension() > 0 || held.motions.dimension() == 0)
    return false;
  const Eigen::Index before = held.motions.dimension();
  held.motions.forbid(row_along(held, tie.node[free], tie.along));
  return held.motions.dimension() < before;
}

/// `from` is fixed, so `to` is fixed at their common node. True if that removed a motion of `to`.
bool Pieces::tie(std::int32_t from, std::int32_t to, std::int64_t node) {
  Piece& held = pieces_[to];
  if (pieces_[from].motions.dimension() > 0 || held.motions.dimension() == 0)
    return false;
  const Eigen::Index before = held.motions.dimension();
  for (int c = 0; c < d_; ++c)
    held.motions.forbid(row(held, node, c));
  return held.motions.dimension() < before;
}

void Pieces::spread_through_joints() {
  for (bool changed = true; changed;) {
    changed = false;
    for (const Joint& joint : joints_)
      for (const std::int32_t from : joint.pieces)
        for (const std::int32_t to : joint.pieces)
          changed = tie(from, to, joint.node) || changed;
    for (const Tie& tie : ties_)
      for (const std::size_t free : {0U, 1U})
        changed = hold(tie, free) || changed;
  }
}

std::string Pieces::motion_left() {
  std::vector<std::int32_t> loose;
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    if (pieces_[p].motions.dimension() > 0)
      loose.push_back(static_cast<std::int32_t>(p));
  return loose.empty() ? std::string{} : joint_motion_left(loose);
}

/// Joint motion of the loose pieces: their motions must agree at all shared nodes.
std::string Pieces::joint_motion_left(const std::vector<std::int32_t>& loose) const {
  std::vector<Eigen::Index> first(pieces_.size(), -1);
  Eigen::Index n = 0;
  for (const std::int32_t p : loose) {
    first[p] = n;
    n += pieces_[p].motions.dimension();
  }
  if (loose.size() > 1 && n > largest_joint_problem)
    return {};
  const auto add_row = [&](Eigen::VectorXd& form, std::int32_t label, const Eigen::VectorXd& of_piece,
                           double factor) {
    const Piece& piece = pieces_[label];
    form.segment(first[label], piece.motions.dimension()) +=
        factor * (piece.motions.basis().transpose() * of_piece);
  };
  const auto add = [&](Eigen::VectorXd& form, std::int32_t label, std::int64_t node, int c, double factor) {
    add_row(form, label, row(pieces_[label], node, c), factor);
  };
  NullSpace left(n);
  for (const Joint& joint : joints_)
    for (std::size_t k = 1; k < joint.pieces.size(); ++k) {
      const std::int32_t one = joint.pieces[k - 1], other = joint.pieces[k];
      if (first[one] < 0 || first[other] < 0)
        continue; // already included: one piece is fixed
      for (int c = 0; c < d_; ++c) {
        Eigen::VectorXd form = Eigen::VectorXd::Zero(n);
        add(form, one, joint.node, c, 1);
        add(form, other, joint.node, c, -1);
        left.forbid(form);
      }
    }
  for (const Tie& tie : ties_) {
    if (left.dimension() == 0)
      break;
    if (first[tie.piece[0]] < 0 || first[tie.piece[1]] < 0)
      continue;
    Eigen::VectorXd form = Eigen::VectorXd::Zero(n);
    for (const std::size_t side : {0U, 1U})
      add_row(form, tie.piece[side], row_along(pieces_[tie.piece[side]], tie.node[side], tie.along),
              side == 0 ? 1 : -1);
    left.forbid(form);
  }
  for (const std::int32_t p : loose) {
    const NullSpace& own = pieces_[p].motions;
    const Eigen::MatrixXd part = left.basis().middleRows(first[p], own.dimension());
    if (part.size() > 0 && part.cwiseAbs().maxCoeff() > 1e-6)
      return describe(static_cast<std::size_t>(p), own.basis() * part);
  }
  return {};
}

std::string direction_in_words(const Eigen::Vector3d& v) {
  const Eigen::Vector3d unit = v.normalized();
  for (int a = 0; a < 3; ++a)
    if (std::abs(unit[a]) > 1 - 1e-9)
      return std::string(1, "xyz"[a]);
  return fmt::format("({:.3g}, {:.3g}, {:.3g})", unit[0], unit[1], unit[2]);
}

/// @param motions columns that span the remaining motions: rotations, then shifts
std::string Pieces::describe(std::size_t piece, const Eigen::MatrixXd& motions) const {
  const Eigen::MatrixXd rows = echelon(motions);
  const int turns = n_motions_ - d_;
  std::string shifts_text, turns_text;
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    Eigen::Vector3d turn = Eigen::Vector3d::Zero(), shift = Eigen::Vector3d::Zero();
    turn.tail(turns == 1 ? 1 : 3).head(turns) = rows.row(k).head(turns).transpose();
    shift.head(d_) = rows.row(k).tail(d_).transpose();
    std::string& text = turn.norm() > 1e-8 ? turns_text : shifts_text;
    text += (text.empty() ? "" : ", ") + direction_in_words(turn.norm() > 1e-8 ? turn : shift);
  }
  const Piece& p = pieces_[piece];
  std::string who = "the body";
  if (scene_->tied.planes > 0) {
    who = fmt::format("label {} ({} cells)", scene_->specimen.label[p.first_cell], p.cells);
  } else if (pieces_.size() > 1) {
    const Vec3 x = scene_->specimen.position(scene_->specimen.grid.cell_at(p.first_cell));
    who = fmt::format("piece {} of {} ({} cells about ({:.4g}, {:.4g}, {:.4g}) m)", piece + 1, pieces_.size(),
                      p.cells, x[0], x[1], x[2]);
  }
  return fmt::format("{} can still {}{}{}{}{}", who, shifts_text.empty() ? "" : "move along ", shifts_text,
                     shifts_text.empty() || turns_text.empty() ? "" : " and ",
                     turns_text.empty() ? "" : "turn about ", turns_text);
}

} // namespace

std::string remaining_rigid_motion(const Scene& scene) {
  if (!scene.sliding.empty())
    return remaining_rigid_motion(split_borders(scene).scene);
  Pieces pieces(scene);
  pieces.add_ties();
  pieces.apply_conditions();
  pieces.apply_springs();
  pieces.spread_through_joints();
  return pieces.motion_left();
}

} // namespace maille
