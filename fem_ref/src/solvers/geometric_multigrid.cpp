#include "solvers/linear_solvers.hpp"

#include "maille/plugins/sparse_cholesky.hpp"

#include "discretization/cell_operator.hpp"
#include "solvers/cg_run.hpp"
#include "solvers/multigrid_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <deal.II/base/mg_level_object.h>
#include <deal.II/lac/diagonal_matrix.h>
#include <deal.II/lac/la_parallel_vector.h>
#include <deal.II/lac/precondition.h>
#include <deal.II/multigrid/mg_smoother.h>
#include <deal.II/multigrid/mg_transfer_matrix_free.h>
#include <deal.II/multigrid/multigrid.h>
#include <memory>
#include <vector>

namespace maille::fem_ref {
namespace {

using Float = dealii::LinearAlgebra::distributed::Vector<float>;
using Double = dealii::LinearAlgebra::distributed::Vector<double>;

constexpr unsigned chebyshev_degree = 4;
constexpr double smoothing_range = 15;
constexpr unsigned eigenvalue_iterations = 10;

/// deal.II's transfer, with zero values at fixed unknowns.
template<int dim>
class Transfer : public dealii::MGTransferMatrixFree<dim, float> {
  using Base = dealii::MGTransferMatrixFree<dim, float>;

public:
  std::vector<std::vector<unsigned>> fixed; ///< by level

  void prolongate(unsigned to, Float& fine, const Float& coarse) const override {
    Base::prolongate(to, fine, coarse);
    clear(to, fine);
  }
  void prolongate_and_add(unsigned to, Float& fine, const Float& coarse) const override {
    Base::prolongate_and_add(to, fine, coarse);
    clear(to, fine);
  }
  void restrict_and_add(unsigned from, Float& coarse, const Float& fine) const override {
    Base::restrict_and_add(from, coarse, fine);
    clear(from - 1, coarse);
  }

private:
  void clear(unsigned level, Float& vector) const {
    for (const unsigned unknown : fixed[level])
      vector.begin()[unknown] = 0;
  }
};

template<int dim>
class LevelProducts : public dealii::MGMatrixBase<Float> {
public:
  std::vector<std::unique_ptr<CellOperator<dim, float>>> levels;

  void vmult(unsigned level, Float& to, const Float& from) const override { levels[level]->vmult(to, from); }
  void vmult_add(unsigned level, Float& to, const Float& from) const override {
    Float product(to);
    vmult(level, product, from);
    to += product;
  }
  void Tvmult(unsigned level, Float& to, const Float& from) const override { vmult(level, to, from); }
  void Tvmult_add(unsigned level, Float& to, const Float& from) const override { vmult_add(level, to, from); }
  unsigned get_minlevel() const override { return 0; }
  unsigned get_maxlevel() const override { return static_cast<unsigned>(levels.size()) - 1; }
};

/// A Cholesky factor of the coarsest level.
template<int dim>
class Bottom : public dealii::MGCoarseGridBase<Float> {
public:
  /// @return false if the level can still move rigidly
  bool factorise(const std::vector<double>& K, const Level<dim>& level) {
    const auto n_rows = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(K.size()))));
    std::vector<bool> is_fixed(level.n_unknowns, false);
    std::vector<Eigen::Triplet<double>> entries;
    for (const unsigned unknown : level.fixed) {
      is_fixed[unknown] = true;
      entries.emplace_back(unknown, unknown, 1.0);
    }
    const std::size_t per_cell = n_rows / dim;
    const auto unknown = [&](std::size_t cell, std::size_t row) {
      return level.nodes[cell * per_cell + row / dim] + static_cast<unsigned>(row % dim);
    };
    for (std::size_t cell = 0; cell < level.nodes.size() / per_cell; ++cell)
      for (std::size_t i = 0; i < n_rows; ++i)
        for (std::size_t j = 0; j < n_rows; ++j)
          if (!is_fixed[unknown(cell, i)] && !is_fixed[unknown(cell, j)])
            entries.emplace_back(unknown(cell, i), unknown(cell, j), K[i * n_rows + j]);
    const auto n = static_cast<Eigen::Index>(level.n_unknowns);
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    std::vector<std::int32_t> node(level.n_unknowns);
    for (std::size_t i = 0; i < node.size(); ++i)
      node[i] = static_cast<std::int32_t>(i / dim);
    matrix = matrix.triangularView<Eigen::Lower>();
    factor_ = sparse_cholesky(matrix, node, false);
    return factor_->factor(matrix) > 0;
  }
  void operator()(unsigned, Float& u, const Float& f) const override {
    Eigen::VectorXd load(static_cast<Eigen::Index>(f.size()));
    std::copy(f.begin(), f.end(), load.begin());
    const Eigen::VectorXd answer = factor_->solve(load);
    std::copy(answer.begin(), answer.end(), u.begin());
  }

private:
  std::unique_ptr<SparseCholesky> factor_;
};

template<int dim>
class MultigridSolver : public PreparedSolver {
public:
  MultigridSolver(const Scene& scene, const Body<dim>& body, const std::vector<bool>& is_prescribed,
                  const Options& options)
      : tolerance_(options.tolerance), mesh_(scene.specimen.grid.cells(), options.degree) {
    number(body);
    make_levels(scene, body, is_prescribed, options.degree);
    smooth();
    multigrid_ =
        std::make_unique<dealii::Multigrid<Float>>(products_, bottom_, transfer_, smoother_, smoother_);
    preconditioner_ = std::make_unique<Preconditioner>(mesh_.numbering(), *multigrid_, transfer_);
  }
  bool is_ready() const { return is_ready_; }
  Solution solve(const dealii::Vector<double>& f, Watch& watch) override;
  std::int64_t bytes() const;

private:
  using LevelOperator = CellOperator<dim, float>;
  using Chebyshev = dealii::PreconditionChebyshev<LevelOperator, Float, dealii::DiagonalMatrix<Float>>;
  using Preconditioner = dealii::PreconditionMG<dim, Float, Transfer<dim>>;

  void number(const Body<dim>& body);
  void make_levels(const Scene& scene, const Body<dim>& body, const std::vector<bool>& is_prescribed,
                   int degree);
  void smooth();

  double tolerance_;
  Mesh<dim> mesh_;
  std::vector<unsigned> unknown_of_; ///< mesh unknown of component 0 for every node of the body
  std::unique_ptr<CellOperator<dim, double>> stiffness_;
  LevelProducts<dim> products_;
  Transfer<dim> transfer_;
  Bottom<dim> bottom_;
  dealii::mg::SmootherRelaxation<Chebyshev, Float> smoother_;
  std::unique_ptr<dealii::Multigrid<Float>> multigrid_;
  std::unique_ptr<Preconditioner> preconditioner_;
  bool is_ready_ = true;
};

template<int dim>
void MultigridSolver<dim>::number(const Body<dim>& body) {
  const Grid& grid = body.specimen().grid;
  unknown_of_.resize(body.n_nodes());
  mesh_.for_each_cell(-1, [&](const Index3& at, const std::vector<unsigned>& nodes) {
    const auto of_body = body.nodes(body.mesh_cell(grid.cell(at)));
    for (std::size_t k = 0; k < nodes.size(); ++k)
      unknown_of_[of_body[k]] = nodes[k];
  });
}

template<int dim>
void MultigridSolver<dim>::make_levels(const Scene& scene, const Body<dim>& body,
                                       const std::vector<bool>& is_prescribed, int degree) {
  const Grid& grid = scene.specimen.grid;
  const Element<dim>& element = body.element();
  NodeLattice<dim> lattice(grid.cells(), degree);
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    const Index3 corner = grid.cell_at(body.grid_cell(cell));
    for (int k = 0; k < element.n_nodes(); ++k) {
      Index3 at{0, 0, 0};
      for (std::size_t a = 0; a < dim; ++a)
        at[a] = degree * corner[a] + element.place(k)[a];
      for (unsigned c = 0; c < dim; ++c)
        if (is_prescribed[dim * body.nodes(cell)[k] + c])
          lattice.fixed(at) |= static_cast<std::uint8_t>(1u << c);
    }
  }
  const Eigen::MatrixXd C = scene.cell_stiffness(body.grid_cell(0));
  const auto n = static_cast<std::size_t>(element.n_unknowns());
  std::vector<double> K(n * n);
  element.stiffness(C, K.data());
  Level<dim> own = make_level(mesh_, -1, lattice, element);
  stiffness_ = std::make_unique<CellOperator<dim, double>>(K, std::move(own.nodes), std::move(own.fixed),
                                                           own.n_unknowns);
  products_.levels.resize(mesh_.n_levels());
  transfer_.fixed.resize(products_.levels.size());
  for (int level = mesh_.n_levels() - 1; level >= 0; --level, lattice = lattice.coarser()) {
    Vec3 spacing = grid.spacing();
    for (std::size_t a = 0; a < dim; ++a)
      spacing[a] *= 1 << (mesh_.n_levels() - 1 - level);
    Element<dim>(degree, spacing).stiffness(C, K.data());
    Level<dim> made = make_level(mesh_, level, lattice, element);
    if (level == 0)
      is_ready_ = bottom_.factorise(K, made);
    const auto i = static_cast<std::size_t>(level);
    transfer_.fixed[i] = made.fixed;
    products_.levels[i] =
        std::make_unique<LevelOperator>(std::vector<float>(K.begin(), K.end()), std::move(made.nodes),
                                        std::move(made.fixed), made.n_unknowns);
  }
  transfer_.build(mesh_.numbering());
}

template<int dim>
void MultigridSolver<dim>::smooth() {
  const unsigned finest = products_.get_maxlevel();
  smoother_.resize(0, finest);
  for (unsigned level = 0; level <= finest; ++level) {
    const LevelOperator& A = *products_.levels[level];
    typename Chebyshev::AdditionalData settings;
    settings.degree = chebyshev_degree;
    settings.smoothing_range = smoothing_range;
    settings.eig_cg_n_iterations = eigenvalue_iterations;
    settings.preconditioner = std::make_shared<dealii::DiagonalMatrix<Float>>();
    settings.preconditioner->get_vector() = A.inverse_diagonal();
    for (const unsigned unknown : A.fixed())
      settings.constraints.add_line(unknown);
    settings.constraints.close();
    smoother_[level].initialize(A, settings);
    Float start; // estimates the largest eigenvalue now, as part of the set-up
    A.initialize_dof_vector(start);
    smoother_[level].estimate_eigenvalues(start);
  }
}

template<int dim>
Solution MultigridSolver<dim>::solve(const dealii::Vector<double>& f, Watch& watch) {
  Solution solution;
  Double load, u;
  stiffness_->initialize_dof_vector(load);
  stiffness_->initialize_dof_vector(u);
  for (std::size_t node = 0; node < unknown_of_.size(); ++node)
    for (unsigned c = 0; c < dim; ++c)
      load.begin()[unknown_of_[node] + c] = f.begin()[dim * node + c];
  run_cg(*stiffness_, u, load, *preconditioner_, tolerance_, watch, solution);
  solution.u.reinit(f.size());
  for (std::size_t node = 0; node < unknown_of_.size(); ++node)
    for (unsigned c = 0; c < dim; ++c)
      solution.u.begin()[dim * node + c] = u.begin()[unknown_of_[node] + c];
  return solution;
}

template<int dim>
std::int64_t MultigridSolver<dim>::bytes() const {
  const auto n = static_cast<std::int64_t>(stiffness_->m());
  std::int64_t bytes = stiffness_->bytes() + static_cast<std::int64_t>(unknown_of_.size() * sizeof(unsigned));
  for (const auto& level : products_.levels)
    bytes += level->bytes() +
             static_cast<std::int64_t>(7 * sizeof(float) * level->m()); // smoother's and cycle's vectors
  return bytes +
         static_cast<std::int64_t>(mesh_.numbering().memory_consumption() +
                                   mesh_.numbering().get_triangulation().memory_consumption() +
                                   transfer_.memory_consumption()) +
         5 * static_cast<std::int64_t>(sizeof(double)) * n;
}

} // namespace

template<int dim>
Preparation prepare_multigrid(const Scene& scene, const Body<dim>& body,
                              const std::vector<bool>& is_prescribed, const Options& options, Watch& watch) {
  watch.report(0.3, "hierarchy of meshes");
  auto solver = std::make_unique<MultigridSolver<dim>>(scene, body, is_prescribed, options);
  if (!solver->is_ready())
    return give_up(Status::failed, "the coarsest mesh can still move without deforming");
  Preparation preparation;
  preparation.bytes = solver->bytes();
  preparation.solver = std::move(solver);
  return preparation;
}

template Preparation prepare_multigrid<2>(const Scene&, const Body<2>&, const std::vector<bool>&,
                                          const Options&, Watch&);
template Preparation prepare_multigrid<3>(const Scene&, const Body<3>&, const std::vector<bool>&,
                                          const Options&, Watch&);

} // namespace maille::fem_ref
