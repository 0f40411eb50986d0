#include "trade/quantity.hpp"

#include "maille/mechanics/recovery.hpp"
#include "trade/lattices.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace maille::studies {

namespace {

std::vector<double> force_of(const Scene& scene, const Answer& answer) {
  const Mechanics mechanics = resultants_of(scene, answer);
  std::vector<double> numbers;
  for (const Resultant& resultant : mechanics.moves.empty() ? mechanics.holds : mechanics.moves)
    numbers.insert(numbers.end(), resultant.force.begin(), resultant.force.end());
  return numbers;
}

std::vector<double> energy_of(const Scene&, const Answer& answer) {
  return answer.strain_energy ? std::vector{*answer.strain_energy} : std::vector<double>{};
}

/// Difference on the cells of the coarser lattice; the finer answer is transferred to its nodes.
std::optional<double> stress_difference(const AnswerOnLattice& coarse, const AnswerOnLattice& fine) {
  Answer carried;
  carried.method = fine.answer->method;
  carried.displacement = between_lattices(*fine.scene, fine.answer->displacement, *coarse.scene);
  return compare_mechanics(*coarse.scene, *coarse.answer, carried).stress;
}

} // namespace

Quantity quantity_of(std::string name,
                     std::function<std::vector<double>(const Scene&, const Answer&)> numbers) {
  Quantity quantity;
  quantity.name = std::move(name);
  quantity.numbers = std::move(numbers);
  quantity.difference = [of = quantity.numbers](const AnswerOnLattice& coarse,
                                                const AnswerOnLattice& fine) -> std::optional<double> {
    const std::vector<double> found = of(*coarse.scene, *coarse.answer),
                              wanted = of(*fine.scene, *fine.answer);
    double difference = 0, size = 0;
    for (std::size_t i = 0; i < wanted.size() && i < found.size(); ++i) {
      difference = std::hypot(difference, found[i] - wanted[i]);
      size = std::hypot(size, wanted[i]);
    }
    return found.size() == wanted.size() && size > 0 ? std::optional(difference / size) : std::nullopt;
  };
  return quantity;
}

std::vector<Quantity> every_quantity() {
  Quantity stress;
  stress.name = "stress";
  stress.difference = stress_difference;
  return {Quantity{}, quantity_of("force", force_of), quantity_of("energy", energy_of), stress};
}

std::optional<Quantity> quantity_named(const std::string& name) {
  const auto all = every_quantity();
  const auto found = std::ranges::find(all, name, &Quantity::name);
  return found == all.end() ? std::nullopt : std::optional(*found);
}

} // namespace maille::studies
