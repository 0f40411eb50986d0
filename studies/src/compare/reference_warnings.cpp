#include "compare/comparison.hpp"

#include "maille/deform/solve.hpp"
#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace maille::studies {
namespace {

constexpr double suspicious_ratio = 1.5; ///< error over its estimate, which is within a factor of 2 at worst
constexpr double negligible = 0.02;
constexpr double worth_an_estimate = 0.03;
constexpr double locking_poisson_ratio = 0.45;
constexpr int too_few_cells = 4; ///< linear elements across a bent body

/// Poisson's ratio of an isotropic material of the same compressibility and the softest shear; for
/// orthotropic materials the shear along their own axes.
double poisson_ratio(const Material& material) {
  const Matrix6 C = stiffness(material.elasticity);
  const double bulk = C.topLeftCorner(3, 3).sum() / 9,
               shear = std::min({C(3, 3), C(4, 4), C(5, 5), (C(0, 0) - C(0, 1)) / 2});
  return shear > 0 ? (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear)) : 0;
}

/// Largest ratio among the body's materials.
double largest_poisson_ratio(const Scene& scene) {
  std::set<std::uint8_t> used;
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      used.insert(scene.specimen.material(cell));
  double largest = 0;
  for (const std::uint8_t material : used)
    largest = std::max(largest, poisson_ratio(scene.materials[material]));
  return largest;
}

/// Smallest mean number of cells in a row, over the axes.
double cells_across(const Scene& scene) {
  const Specimen& body = scene.specimen;
  double least = static_cast<double>(body.grid.n_cells());
  for (int axis = 0; axis < scene.dimension(); ++axis) {
    std::int64_t n_rows = 0; // a row begins at a cell that has none before it
    for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
      if (!body.is_matter(cell))
        continue;
      Index3 before = body.grid.cell_at(cell);
      --before[axis];
      n_rows += before[axis] < 0 || !body.is_matter(body.grid.cell(before)) ? 1 : 0;
    }
    least = std::min(least, static_cast<double>(body.n_matter_cells()) / static_cast<double>(n_rows));
  }
  return least;
}

constexpr std::string_view advice = "--reference best finds a better one, and says how good it is";

/// Conclusion about the reference from an error and its estimate.
std::string contradiction(const std::string& method, const std::string& reference, double error,
                          double estimate) {
  if (error > suspicious_ratio * estimate && error > estimate + negligible)
    return fmt::format(
        "{} is {} from {}, but only about {} from elasticity by its estimate: {} itself may be off by {} "
        "to {}; {}",
        method, in_percent(error), reference, in_percent(estimate), reference, in_percent(error - estimate),
        in_percent(error + estimate), advice);
  if (3 * error < estimate && estimate > 0.05)
    return fmt::format(
        "{} is {} from {}, but about {} from elasticity by its estimate: both may share an error of up to {} "
        "on cells as large as these; {}",
        method, in_percent(error), reference, in_percent(estimate), in_percent(error + estimate), advice);
  return {};
}

/// Known reasons that linear elements are too stiff in this body, in words; empty without one. Finite-strain
/// elements have their own pressure and do not lock by incompressibility.
std::string known_to_lock(const Scene& scene) {
  const double nu = largest_poisson_ratio(scene), cells = cells_across(scene);
  const std::string nearly_incompressible = scene.strain == Strain::small && nu >= locking_poisson_ratio
                                                ? fmt::format("in matter of a Poisson ratio of {:.3g}", nu)
                                                : "";
  const std::string thin =
      cells < too_few_cells ? fmt::format("in bodies {:.2g} cells across that bend", cells) : "";
  if (nearly_incompressible.empty() && thin.empty())
    return {};
  return fmt::format("fem_q1: linear elements are too stiff {}{}{}", nearly_incompressible,
                     nearly_incompressible.empty() || thin.empty() ? "" : " and ", thin);
}

const ComparisonRow* settled_row(const Comparison& comparison, std::string_view method) {
  const auto row = std::ranges::find_if(comparison.rows,
                                        [&](const ComparisonRow& r) { return r.answer.method == method; });
  return row != comparison.rows.end() && is_converged(row->answer.status) ? &*row : nullptr;
}

} // namespace

std::vector<std::string> reference_warnings(const Scene& scene, const Comparison& comparison,
                                            const Control& control) {
  std::vector<std::string> warnings;
  const std::string& reference = comparison.reference;
  const ComparisonRow* const truth = comparison.reference_row();
  if ((reference != "fem_q1" && reference != "fem_q2") || !truth || !is_converged(truth->answer.status))
    return warnings;
  const auto judge = [&](const ComparisonRow& row, const deform::ErrorEstimation& found) {
    if (row.error && found.estimate)
      if (std::string text = contradiction(row.answer.method, reference, row.error->relative_l2,
                                           found.estimate->norms.relative_l2);
          !text.empty())
        warnings.push_back(std::move(text));
  };
  for (const ComparisonRow& row : comparison.rows)
    if (row.estimation && is_converged(row.answer.status))
      judge(row, *row.estimation);
  const ComparisonRow* const coupled = settled_row(comparison, "coupled");
  const bool is_far = coupled && coupled->error && coupled->error->relative_l2 > worth_an_estimate;
  if (is_far && !coupled->estimation)
    judge(*coupled, deform::estimate_error(scene, coupled->answer.displacement, control));
  if (!warnings.empty() || reference != "fem_q1" || (coupled && !is_far))
    return warnings;
  if (const std::string text = known_to_lock(scene); !text.empty())
    warnings.push_back(
        fmt::format("{}: {}; {}", text,
                    coupled ? fmt::format("the {} to coupled may be its own error for the most part",
                                          in_percent(coupled->error->relative_l2))
                            : "it may be off by some 10 % to 90 %",
                    advice));
  return warnings;
}

} // namespace maille::studies
