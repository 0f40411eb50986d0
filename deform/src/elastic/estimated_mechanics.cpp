#include "elastic/estimated_mechanics.hpp"

#include "elastic/krylov/coupled_task.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "maille/scene/cell_fields.hpp"

#include <array>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// The corrected state with the forces and energy of full elasticity on the lattice; at finite strain the
/// correction already has them.
Answer with_forces(const Scene& scene, const Answer& elastic) {
  Answer state;
  state.method = "coupled";
  state.displacement = elastic.displacement;
  state.reaction = elastic.reaction;
  state.strain_energy = elastic.strain_energy;
  if (scene.strain == Strain::finite)
    return state;
  ThreadTeam alone(1);
  Displacement forces(scene.specimen.grid);
  LatticeElasticity(scene).apply(state.displacement, forces, alone);
  state.strain_energy = 0.5 * product(state.displacement, forces);
  state.reaction = reactions_of(scene, loads_of(scene), forces);
  return state;
}

/// to + factor (a - b)
void add_difference(double factor, std::span<const double> a, std::span<const double> b,
                    std::span<double> to) {
  for (std::size_t i = 0; i < to.size(); ++i)
    to[i] += factor * (a[i] - b[i]);
}

/// compare_mechanics() of base + error against base, relative to the nearest known state, without the safety
/// margin.
MechanicsErrors over(const Scene& scene, const Answer& base, Answer error_and_base, const Answer& answer) {
  error_and_base.method = answer.method;
  if (answer.reaction.empty())
    error_and_base.reaction.clear();
  if (!answer.strain_energy)
    error_and_base.strain_energy.reset();
  return compare_mechanics(scene, error_and_base, base);
}

} // namespace

Answer mechanics_in_object(const Scene& scene, const Frame& frame, const Answer& answer,
                           const Displacement& u) {
  Answer within;
  within.method = answer.method;
  within.displacement = u;
  within.reaction = answer.reaction;
  within.strain_energy = answer.strain_energy;
  if (!frame.is_turned || answer.reaction.empty())
    return within;
  const int d = scene.dimension(); // every moved node has all components, by component, then by node
  const std::size_t n = answer.reaction.size() / static_cast<std::size_t>(d);
  for (std::size_t i = 0; i < n; ++i)
    for (int a = 0; a < d; ++a) {
      double& force = within.reaction[static_cast<std::size_t>(a) * n + i];
      force = 0;
      for (int b = 0; b < d; ++b)
        force += frame.rotation(b, a) * answer.reaction[static_cast<std::size_t>(b) * n + i];
    }
  return within;
}

MechanicsErrors mechanics_by_finer(const Scene& scene, const Answer& answer, const Answer& elastic,
                                   const Answer& finer, bool is_along_lines) {
  const Answer here = with_forces(scene, elastic);
  Answer best = finer, wrong = finer;
  best.method = here.method;
  // Errors over the parts that half the spacing removes: the 90th percentile over scenes other than those
  // that the estimates are checked on (docs/developers/relaxation.md).
  const double left = is_along_lines ? 4 : 1.5, left_of_fields = is_along_lines ? 4 : 1.3;
  add_difference(1, answer.displacement.values(), here.displacement.values(), wrong.displacement.values());
  add_difference(left_of_fields, here.displacement.values(), finer.displacement.values(),
                 wrong.displacement.values());
  const std::vector<std::array<double, 6>> of_answer = cell_fields(scene, answer.displacement).strain,
                                           of_here = cell_fields(scene, here.displacement).strain;
  for (std::size_t cell = 0; cell < wrong.cell_strain.size(); ++cell)
    for (std::size_t k = 0; k < 6; ++k)
      wrong.cell_strain[cell][k] += of_answer[cell][k] - of_here[cell][k] +
                                    left_of_fields * (of_here[cell][k] - finer.cell_strain[cell][k]);
  if (!answer.reaction.empty()) {
    add_difference(1, answer.reaction, here.reaction, wrong.reaction);
    add_difference(left, here.reaction, finer.reaction, wrong.reaction);
  }
  if (answer.strain_energy && finer.strain_energy)
    *wrong.strain_energy +=
        *answer.strain_energy - *here.strain_energy + left * (*here.strain_energy - *finer.strain_energy);
  return over(scene, best, std::move(wrong), answer);
}

MechanicsErrors mechanics_of_model(const Scene& scene, const Answer& answer, const Answer& elastic,
                                   const Displacement& error) {
  const Answer here = with_forces(scene, elastic);
  Answer wrong = answer;
  wrong.displacement = here.displacement;
  for (std::size_t i = 0; i < error.values().size(); ++i)
    wrong.displacement.values()[i] += error.values()[i];
  return over(scene, here, std::move(wrong), answer);
}

} // namespace maille::deform
