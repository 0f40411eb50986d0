#include "elastic/box/box_coarsest.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>

namespace maille::deform {

namespace {

constexpr std::int64_t most_nodes_inverted = 36;
/// Multiplications that factors of a thin level may cost: at least, where its cells are flat and relaxation
/// is of little help, and for each node of the finest level.
constexpr double most_products = 1e9, most_products_of_flat = 2e10, products_per_node = 2e4;
/// Cells are flat that are so many times as long as they are thick.
constexpr double flat = 2.5;

/// The inverse, but for rigid motions, where too little is fixed on a level: they stay out of the correction.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& K) {
  constexpr double nothing = 1e-9; // beside the stiffness of a node
  const Eigen::Index n = K.rows();
  if (n == 0)
    return K;
  const Eigen::LLT<Eigen::MatrixXd> factors(K);
  if (factors.info() == Eigen::Success &&
      (factors.matrixLLT().diagonal().array().square() / K.diagonal().array()).minCoeff() > nothing)
    return factors.solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(K);
  const double smallest = nothing * modes.eigenvalues()(n - 1);
  const Eigen::VectorXd inverted =
      modes.eigenvalues().unaryExpr([&](double value) { return value > smallest ? 1 / value : 0.0; });
  return modes.eigenvectors() * inverted.asDiagonal() * modes.eigenvectors().transpose();
}

int longest_axis(const Index3& nodes) {
  return static_cast<int>(std::ranges::max_element(nodes) - nodes.begin());
}

Index3 nodes_of(const BoxLevel& level) {
  return {level.A().nodes[0], level.A().nodes[1], level.A().nodes[2]};
}

std::int64_t n_nodes_of(const Index3& nodes) {
  return std::int64_t{1} * nodes[0] * nodes[1] * nodes[2];
}

/// Rows of the factor of a layer.
double unknowns_in_layer(const Index3& nodes) {
  return 3 * static_cast<double>(n_nodes_of(nodes)) / nodes[static_cast<std::size_t>(longest_axis(nodes))];
}

bool is_thin_lattice(const Index3& nodes, const Vec3& spacing, std::int64_t n_finest) {
  const auto thin = static_cast<std::size_t>(std::ranges::min_element(nodes) - nodes.begin()),
             along = static_cast<std::size_t>(longest_axis(nodes));
  const double in_layer = unknowns_in_layer(nodes);
  const double most = std::max(spacing[along] > flat * spacing[thin] ? most_products_of_flat : most_products,
                               products_per_node * static_cast<double>(n_finest));
  return nodes[thin] == 2 && 3 * nodes[along] * in_layer * in_layer * in_layer <= most;
}

} // namespace

bool BoxCoarsest::is_small(const BoxLevel& level) {
  return level.n_nodes() <= most_nodes_inverted;
}

bool BoxCoarsest::is_thin(const BoxLevel& level, std::int64_t n_finest) {
  return is_thin_lattice(nodes_of(level), {level.spacing(0), level.spacing(1), level.spacing(2)}, n_finest);
}

std::int64_t BoxCoarsest::bytes_at_most(const BoxLevel::Stiffness& C, const Grid& grid) {
  constexpr std::int64_t per_unknown = 24;
  Index3 nodes = grid.nodes();
  Vec3 spacing = grid.spacing();
  while (n_nodes_of(nodes) > most_nodes_inverted) {
    if (is_thin_lattice(nodes, spacing, grid.n_nodes())) {
      const double in_layer = unknowns_in_layer(nodes);
      return 3 * per_unknown * n_nodes_of(nodes) +
             static_cast<std::int64_t>(2 * sizeof(double) * in_layer *
                                       static_cast<double>(3 * n_nodes_of(nodes)));
    }
    const auto coarsens = axes_to_coarsen(nodes, BoxCoefficients(C, spacing, 1));
    if (std::ranges::find(coarsens, true) == coarsens.end())
      break;
    for (std::size_t a = 0; a < 3; ++a)
      if (coarsens[a]) {
        nodes[a] = (nodes[a] - 1) / 2 + 1;
        spacing[a] *= 2;
      }
  }
  return 0; // an inverse of 108 rows at most
}

BoxCoarsest::BoxCoarsest(const BoxLevel& level) : level_(level), along_(longest_axis(nodes_of(level))) {
  number_unknowns();
}

void BoxCoarsest::number_unknowns() {
  const BoxOperator& A = level_.A();
  const int layers = is_small(level_) ? 1 : A.nodes[along_];
  number_.assign(static_cast<std::size_t>(3 * n_nodes()), -1);
  for (int layer = 0; layer < layers; ++layer) {
    first_.push_back(unknowns_.size());
    for (int c = 0; c < 3; ++c)
      for (int z = 0; z < A.nodes[2]; ++z)
        for (int y = 0; y < A.nodes[1]; ++y)
          for (int x = 0; x < A.nodes[0]; ++x) {
            const int at[3] = {x, y, z};
            if ((layers > 1 && at[along_] != layer) || !level_.may_move(c, x, y, z))
              continue;
            const std::int64_t node = x + std::int64_t{A.nodes[0]} * (y + std::int64_t{A.nodes[1]} * z);
            number_[static_cast<std::size_t>(3 * node + c)] = static_cast<std::int32_t>(unknowns_.size());
            unknowns_.push_back(level_.offset(c, x, y, z));
          }
  }
  first_.push_back(unknowns_.size());
}

/// Calls visit(row, column, value) for the entries of the operator between unknowns. It is applied to every
/// third node along each axis at once: their neighbours are no one else's.
template<class Visit>
void BoxCoarsest::for_each_entry(const Visit& visit) const {
  const BoxOperator& A = level_.A();
  const std::int64_t n = n_nodes(), in_plane = std::int64_t{A.nodes[0]} * A.nodes[1];
  std::vector<double> u(static_cast<std::size_t>(3 * n)), plane(static_cast<std::size_t>(3 * in_plane));
  AlignedArray<double> scratch(static_cast<std::size_t>(box_scratch_bytes(A)) / sizeof(double) + 1);
  const auto node_of = [&](int x, int y, int z) {
    return x + A.nodes[0] * (y + std::int64_t{A.nodes[1]} * z);
  };
  const auto number = [&](std::int64_t node, int c) {
    return number_[static_cast<std::size_t>(3 * node + c)];
  };
  for (int colour = 0; colour < 81; ++colour) {
    const int component = colour / 27, of[3] = {colour % 3, colour / 3 % 3, colour / 9 % 3};
    std::ranges::fill(u, 0.0);
    for (int z = of[2]; z < A.nodes[2]; z += 3)
      for (int y = of[1]; y < A.nodes[1]; y += 3)
        for (int x = of[0]; x < A.nodes[0]; x += 3)
          u[static_cast<std::size_t>(component * n + node_of(x, y, z))] = 1;
    const auto nearest = [&](int axis, int i) { return i - 1 + ((of[axis] - i + 1) % 3 + 3) % 3; };
    for (int z = 0; z < A.nodes[2]; ++z) {
      apply_box(A, z, u.data(), plane.data(), scratch.data());
      for (int y = 0; y < A.nodes[1]; ++y)
        for (int x = 0; x < A.nodes[0]; ++x) {
          const int at[3] = {nearest(0, x), nearest(1, y), nearest(2, z)};
          if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= A.nodes[0] || at[1] >= A.nodes[1] ||
              at[2] >= A.nodes[2])
            continue;
          const std::int32_t column = number(node_of(at[0], at[1], at[2]), component);
          for (int c = 0; c < 3 && column >= 0; ++c)
            if (const std::int32_t row = number(node_of(x, y, z), c); row >= 0)
              visit(static_cast<std::size_t>(row), static_cast<std::size_t>(column),
                    plane[static_cast<std::size_t>(c * in_plane + x + y * A.nodes[0])]);
        }
    }
  }
  std::vector<std::pair<std::int64_t, std::int32_t>> places; // of unknowns, to find those of links
  for (std::size_t i = 0; i < unknowns_.size() && !level_.penalties().ends().empty(); ++i)
    places.emplace_back(unknowns_[i], static_cast<std::int32_t>(i));
  std::ranges::sort(places);
  const auto unknown_at = [&](std::int64_t at) {
    const auto place =
        std::ranges::lower_bound(places, at, {}, &std::pair<std::int64_t, std::int32_t>::first);
    return place != places.end() && place->first == at ? place->second : -1;
  };
  for (const PenaltyRows::End& end : level_.penalties().ends()) {
    const std::int32_t row = unknown_at(end.at), column = unknown_at(end.other);
    if (row < 0)
      continue;
    visit(static_cast<std::size_t>(row), static_cast<std::size_t>(row), double{end.stiffness});
    if (column >= 0)
      visit(static_cast<std::size_t>(row), static_cast<std::size_t>(column), -double{end.stiffness});
  }
}

void BoxCoarsest::factor_small() {
  const auto n = static_cast<Eigen::Index>(unknowns_.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  for_each_entry([&](std::size_t row, std::size_t column, double value) {
    K(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) += value;
  });
  inverse_ = pseudo_inverse(K).cast<float>();
}

bool BoxCoarsest::factor_layers() {
  constexpr double nothing = 1e-13; // of a pivot, beside the stiffness of its node
  const std::size_t n = first_.size() - 1;
  lower_.assign(n, {});
  beside_.assign(n, {});
  std::vector<std::size_t> layer_of(unknowns_.size());
  const auto size = [&](std::size_t layer) {
    return static_cast<Eigen::Index>(first_[layer + 1] - first_[layer]);
  };
  for (std::size_t layer = 0; layer < n; ++layer) {
    lower_[layer] = Eigen::MatrixXd::Zero(size(layer), size(layer));
    beside_[layer] = Eigen::MatrixXd::Zero(size(layer), layer > 0 ? size(layer - 1) : 0);
    std::fill(layer_of.begin() + static_cast<std::ptrdiff_t>(first_[layer]),
              layer_of.begin() + static_cast<std::ptrdiff_t>(first_[layer + 1]), layer);
  }
  for_each_entry([&](std::size_t row, std::size_t column, double value) {
    const std::size_t layer = layer_of[row], other = layer_of[column];
    const auto i = static_cast<Eigen::Index>(row - first_[layer]),
               j = static_cast<Eigen::Index>(column - first_[other]);
    if (other == layer)
      lower_[layer](i, j) += value;
    else if (other + 1 == layer)
      beside_[layer](i, j) += value;
  });
  for (std::size_t layer = 0; layer < n; ++layer) {
    Eigen::MatrixXd& S = lower_[layer];
    const Eigen::VectorXd diagonal = S.diagonal();
    if (layer > 0 && size(layer) > 0 && size(layer - 1) > 0) {
      beside_[layer] = lower_[layer - 1]
                           .triangularView<Eigen::Lower>()
                           .solve(beside_[layer].transpose())
                           .transpose()
                           .eval();
      S.selfadjointView<Eigen::Lower>().rankUpdate(beside_[layer], -1);
    }
    const Eigen::LLT<Eigen::MatrixXd> factors(S.selfadjointView<Eigen::Lower>());
    if (size(layer) == 0)
      continue;
    if (factors.info() != Eigen::Success)
      return false;
    S = factors.matrixL();
    if ((S.diagonal().array().square() / diagonal.array()).minCoeff() < nothing)
      return false;
  }
  return true;
}

bool BoxCoarsest::factor() {
  if (!is_small(level_))
    return factor_layers();
  factor_small();
  return true;
}

void BoxCoarsest::solve(BoxLevel& level) const {
  const std::size_t n = first_.size() - 1;
  const auto size = [&](std::size_t layer) {
    return static_cast<Eigen::Index>(first_[layer + 1] - first_[layer]);
  };
  if (is_small(level_)) {
    Eigen::VectorXf force(static_cast<Eigen::Index>(unknowns_.size()));
    for (std::size_t i = 0; i < unknowns_.size(); ++i)
      force[static_cast<Eigen::Index>(i)] = level.f.data()[unknowns_[i]];
    const Eigen::VectorXf u = inverse_ * force;
    for (std::size_t i = 0; i < unknowns_.size(); ++i)
      level.u.data()[unknowns_[i]] = u[static_cast<Eigen::Index>(i)];
    return;
  }
  std::vector<Eigen::VectorXd> x(n);
  for (std::size_t layer = 0; layer < n; ++layer) {
    x[layer].resize(size(layer));
    for (Eigen::Index i = 0; i < size(layer); ++i)
      x[layer][i] = double{level.f.data()[unknowns_[first_[layer] + static_cast<std::size_t>(i)]]};
    if (layer > 0)
      x[layer].noalias() -= beside_[layer] * x[layer - 1];
    lower_[layer].triangularView<Eigen::Lower>().solveInPlace(x[layer]);
  }
  for (std::size_t layer = n; layer-- > 0;) {
    if (layer + 1 < n)
      x[layer].noalias() -= beside_[layer + 1].transpose() * x[layer + 1];
    lower_[layer].triangularView<Eigen::Lower>().adjoint().solveInPlace(x[layer]);
    for (Eigen::Index i = 0; i < size(layer); ++i)
      level.u.data()[unknowns_[first_[layer] + static_cast<std::size_t>(i)]] =
          static_cast<float>(x[layer][i]);
  }
}

std::int64_t BoxCoarsest::bytes() const {
  auto sum = static_cast<std::int64_t>(inverse_.size()) * std::int64_t{sizeof(float)} +
             static_cast<std::int64_t>(unknowns_.size() * sizeof(std::int64_t) +
                                       number_.size() * sizeof(std::int32_t));
  for (const auto* blocks : {&lower_, &beside_})
    for (const Eigen::MatrixXd& block : *blocks)
      sum += static_cast<std::int64_t>(block.size()) * std::int64_t{sizeof(double)};
  return sum;
}

} // namespace maille::deform
