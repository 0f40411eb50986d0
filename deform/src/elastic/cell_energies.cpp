// The energy that the elastic methods minimise, cell by cell.
#include "elastic/finite/finite_elasticity.hpp"
#include "elastic/model/cell_moduli.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"
#include "parallel/thread_team.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace maille::deform {

namespace {

/// Displacements of the corners of a cell relative to its first corner; columns are corners.
template<int dimension>
using Corners = Eigen::Matrix<double, 3, 1 << dimension>;

template<int dimension>
Corners<dimension> corners_of(const Grid& grid, const Displacement& u, std::int64_t cell) {
  const Index3 at = grid.cell_at(cell);
  Corners<dimension> of = Corners<dimension>::Zero();
  for (int corner = 0; corner < 1 << dimension; ++corner)
    for (int b = 0; b < dimension; ++b)
      of(b, corner) = u(b, grid.corner(at, corner)) - u(b, grid.corner(at, 0));
  return of;
}

/// Energies of `coupled`.
template<int dimension>
std::vector<double> lattice_energies(const Scene& scene, const Displacement& u, int threads) {
  const Grid& grid = scene.specimen.grid;
  ThreadTeam team(threads);
  const LatticeElasticity lattice(scene, team);
  if (scene.strain == Strain::finite) {
    FiniteElasticity elasticity(scene, lattice);
    Displacement forces(grid);
    elasticity.evaluate(u, forces, team);
    return elasticity.energies();
  }
  std::vector<double> energy(grid.n_cells(), 0);
  for_parts(energy.size(), team, [&](std::size_t first, std::size_t end, std::size_t) {
    for (std::size_t c = first; c < end; ++c) {
      const auto cell = static_cast<std::int64_t>(c);
      if (!scene.specimen.is_matter(cell))
        continue;
      const Corners<dimension> of = corners_of<dimension>(grid, u, cell);
      energy[c] = 0.5 * of.cwiseProduct(lattice.cell_forces<dimension>(cell, of)).sum();
    }
  });
  return energy;
}

/// Energies of `relaxed`: each cell's share of the weights of its edges.
template<int dimension>
std::vector<double> link_energies(const Scene& scene, const Displacement& u) {
  const Grid& grid = scene.specimen.grid;
  const CellModuli moduli(scene, CellModuli::Weights::of_relaxed);
  double volume_of_edge = 1.0 / (1 << (dimension - 1));
  for (std::size_t a = 0; a < dimension; ++a)
    volume_of_edge *= grid.spacing()[a];
  std::vector<double> energy(grid.n_cells(), 0);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const CellModuli::Table& modulus = moduli[cell];
    const Corners<dimension> of = corners_of<dimension>(grid, u, cell);
    double twice = 0;
    for (int corner = 0; corner < 1 << dimension; ++corner)
      for (int a = 0; a < dimension; ++a)
        for (int b = 0; b < dimension && !(corner >> a & 1); ++b) {
          const double slope = (of(b, corner | 1 << a) - of(b, corner)) / grid.spacing()[a];
          twice += modulus[a][b] * slope * slope;
        }
    energy[cell] = 0.5 * volume_of_edge * twice;
  }
  return energy;
}

template<int dimension>
std::vector<double> energies(const Scene& scene, const Answer& answer, int threads) {
  const bool is_coupled = answer.method == "coupled";
  const Frame frame = is_coupled && in_blocks(scene) ? Frame{} : object_frame(scene);
  Displacement within;
  if (frame.is_turned)
    to_object(scene, frame, within = answer.displacement);
  const Displacement& u = frame.is_turned ? within : answer.displacement;
  return is_coupled ? lattice_energies<dimension>(scene, u, threads) : link_energies<dimension>(scene, u);
}

} // namespace

std::vector<double> cell_energies(const Scene& scene, const Answer& answer, int threads) {
  const bool is_relaxed = answer.method == "relaxed";
  if (is_relaxed && scene.relaxation.mode == RelaxationMode::deformable)
    return std::vector<double>(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  if (!has_displacement(answer.status) || !(is_relaxed || answer.method == "coupled"))
    return answer.cell_energy;
  if (!answer.split.empty()) // defined on each side separately; the displacement stores the mean of both
    return answer.cell_energy;
  const int dimension = scene.dimension();
  return dimension == 1   ? energies<1>(scene, answer, threads)
         : dimension == 2 ? energies<2>(scene, answer, threads)
                          : energies<3>(scene, answer, threads);
}

} // namespace maille::deform
