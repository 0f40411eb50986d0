#include "maille/scene/plausibility.hpp"

#include "maille/base/vectors.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/voxel_map.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>

namespace maille {

namespace {

constexpr double largest_small_strain = 0.1, largest_cell = 0.01, largest_body = 10; // 1, m, m
/// Deflection over length: beyond it the end of a cantilever rotates by more than 17 degrees.
constexpr double largest_small_deflection = 0.2;
/// Above the strength of any matter, which is some 1e11 Pa: an exponential law says so where it is stretched.
constexpr double greatest_stress = 1e12; // [Pa]
/// Loads above this fraction of the stiffness compress cells to half their length.
constexpr double most_of_stiffness = 0.5;

struct LengthUnit {
  const char* name;
  double metres;
};

/// Millimetres, the usual unit, for 0.01 to 1000 mm; else another unit.
LengthUnit unit_for(double length) {
  constexpr double rounding = 1e-9;
  if (length >= 1 - rounding)
    return {"m", 1};
  if (length >= 1e-5 * (1 - rounding))
    return {"mm", 1e-3};
  if (length >= 1e-6 * (1 - rounding))
    return {"um", 1e-6};
  return length > 0 ? LengthUnit{"nm", 1e-9} : LengthUnit{"mm", 1e-3};
}

struct PrescribedNode {
  Vec3 displacement{};
  std::array<bool, 3> held{};
};

std::map<std::int64_t, PrescribedNode> by_node(const Scene& scene) {
  std::map<std::int64_t, PrescribedNode> nodes;
  for (const Prescribed& p : scene.prescribed) {
    PrescribedNode& node = nodes[p.node];
    node.displacement[p.component] = p.value;
    node.held[p.component] = p.held;
  }
  return nodes;
}

/// Mean strain: largest move relative to the nearest fixed node, or to the node that moves least.
std::optional<double> mean_strain(const Scene& scene, const std::map<std::int64_t, PrescribedNode>& nodes) {
  const auto most =
      std::ranges::max_element(nodes, {}, [](const auto& entry) { return norm(entry.second.displacement); });
  // A plane that only prevents sideways motion is no hold against a move along it.
  const auto holds = [&](const PrescribedNode& node) {
    for (std::size_t b = 0; b < 3; ++b)
      if (node.held[b] && most->second.displacement[b] != 0)
        return true;
    return false;
  };
  const bool any_held = std::ranges::any_of(nodes, [&](const auto& entry) { return holds(entry.second); });
  const auto at = [&](std::int64_t node) {
    return scene.specimen.position(scene.specimen.grid.node_at(node));
  };
  const Vec3 from = at(most->first);
  const double least = norm(std::ranges::min_element(nodes, {}, [](const auto& entry) {
                              return norm(entry.second.displacement);
                            })->second.displacement);
  double nearest = std::numeric_limits<double>::infinity(), difference = 0;
  for (const auto& [number, node] : nodes) {
    const bool counts = number != most->first && (any_held ? holds(node) : norm(node.displacement) <= least);
    if (const double d = distance(from, at(number)); counts && d < nearest) {
      nearest = d;
      difference = distance(most->second.displacement, node.displacement);
    }
  }
  return std::isfinite(nearest) && nearest > 0 ? std::optional(difference / nearest) : std::nullopt;
}

double least_modulus(const Material& material) {
  return *std::ranges::min_element(material.elasticity.youngs_modulus);
}

/// Strain of contracting fibres by the stiffness along them, and of tractions by the softest direction of the
/// loaded matter.
std::optional<double> strain_of_loads(const Scene& scene) {
  double strain = 0;
  for (std::size_t cell = 0; cell < scene.active_stress.size(); ++cell)
    if (scene.specimen.is_matter(static_cast<std::int64_t>(cell))) {
      const Material& material = scene.materials[scene.specimen.material(static_cast<std::int64_t>(cell))];
      strain = std::max(strain, scene.active_stress[cell] / material.elasticity.youngs_modulus[0]);
    }
  for (const FaceLoad& load : scene.tractions)
    strain = std::max(strain, norm(load.traction) /
                                  least_modulus(scene.materials[scene.specimen.material(load.cell)]));
  return strain > 0 ? std::optional(strain) : std::nullopt;
}

std::string percent(double share) {
  return fmt::format("{:.3g} %", 100 * share);
}

void warn_of_sizes(const Scene& scene, Plausibility& found) {
  const Vec3& spacing = scene.specimen.grid.spacing();
  const double cell = *std::max_element(spacing.begin(), spacing.begin() + scene.dimension());
  const double body = *std::ranges::max_element(found.size);
  if (cell > largest_cell)
    found.warnings.push_back(
        fmt::format("cells of {}: is the spacing in the unit that was meant?", length_in_words(cell)));
  if (body > largest_body)
    found.warnings.push_back(
        fmt::format("a body of {}: is the spacing in the unit that was meant?", length_in_words(body)));
  if (found.move_over_length > 1)
    found.warnings.push_back(
        fmt::format("a move of {}, {} of the body's length: is it in the unit that was meant?",
                    length_in_words(found.largest_move), percent(found.move_over_length)));
}

/// The force depends on the nodes under the punch: too few of them resolve its radius poorly.
void warn_of_punch(const Scene& scene, Plausibility& found) {
  constexpr double fewest_cells = 4, rounding = 0.1;
  if (!scene.test || scene.test->kind != TestKind::indent)
    return;
  double cell = 0;
  for (int a = 0; a < scene.dimension(); ++a)
    if (static_cast<int>(a) != scene.test->axis)
      cell = std::max(cell, scene.specimen.grid.spacing()[a]);
  if (const double cells = scene.test->radius / cell; cells < fewest_cells - rounding)
    found.warnings.push_back(
        fmt::format("the punch has a radius of {:.2g} cells: its force is good to some per "
                    "cent from {:g} cells on",
                    cells, fewest_cells));
}

void warn_of_strains(const Scene& scene, Plausibility& found) {
  constexpr const char* limit =
      "relaxed, coupled and finite elements are small-strain elasticity, good up to some 10 %: strain = "
      "\"finite\" has no such bound";
  const bool is_finite = scene.strain == Strain::finite,
             have_laws =
                 std::ranges::all_of(scene.materials, [](const Material&m) { return m.law.has_value(); });
  if (found.mean_strain > largest_small_strain && !(is_finite && have_laws))
    found.warnings.push_back(fmt::format(
        "the moves ask for a mean strain of {}; {}", percent(*found.mean_strain),
        is_finite ? "the stress of a material without a law is linear in strain, good up to some 10 %"
                  : limit));
  if (!(is_finite && have_laws) &&
      found.strain_of_loads > (is_finite ? most_of_stiffness : largest_small_strain))
    found.warnings.push_back(fmt::format(
        "the {} is {} of the stiffness that it works against; {}",
        scene.contracts() ? "contraction" : "traction", percent(*found.strain_of_loads),
        found.strain_of_loads > most_of_stiffness ? "cells may turn inside out: less load, or stiffer matter"
                                                  : limit));
  for (const Material& material : scene.materials)
    if (material.damage && found.mean_strain > *std::ranges::min_element(material.damage->stretch) - 1)
      found.warnings.push_back(fmt::format("a mean strain of {}, and {} fails at a stretch of {:.3g}",
                                           percent(*found.mean_strain), material.name,
                                           *std::ranges::min_element(material.damage->stretch)));
}

} // namespace

Plausibility plausibility(const Scene& scene) {
  Plausibility found;
  const Grid& grid = scene.specimen.grid;
  for (int a = 0; a < grid.dimension(); ++a)
    found.size[a] = grid.cells()[a] * grid.spacing()[a];
  const auto nodes = by_node(scene);
  for (const auto& [number, node] : nodes)
    found.largest_move = std::max(found.largest_move, norm(node.displacement));
  if (const double length = *std::ranges::max_element(found.size); length > 0)
    found.move_over_length = found.largest_move / length;
  const bool turns = !scene.turns.empty() ||
                     std::ranges::any_of(scene.drives, [](const Drive& drive) { return drive.turned() > 0; });
  if (found.largest_move > 0 && !turns)
    found.mean_strain = mean_strain(scene, nodes);
  if (scene.contracts() || !scene.tractions.empty())
    found.strain_of_loads = strain_of_loads(scene);
  warn_of_sizes(scene, found);
  warn_of_punch(scene, found);
  warn_of_strains(scene, found);
  std::ranges::move(statement_warnings(scene), std::back_inserter(found.warnings));
  return found;
}

std::vector<std::string> implausible_answer(const Scene& scene, const Plausibility& question,
                                            const std::string& method, double largest_displacement,
                                            const PartMechanics& body) {
  if (scene.strain == Strain::finite || !body.von_mises || !body.largest_strain || !body.smallest_strain ||
      question.mean_strain > largest_small_strain)
    return {};
  std::vector<std::string> warnings;
  const double strain = std::max(body.largest_strain->percentile_95, -body.smallest_strain->percentile_5);
  if (strain > largest_small_strain)
    warnings.push_back(fmt::format("by {} a twentieth of the body is strained by {} or more; small-strain "
                                   "elasticity is good up to some 10 %",
                                   method, percent(strain)));
  const double length = *std::ranges::max_element(question.size);
  if (largest_displacement > question.largest_move + largest_small_deflection * length)
    warnings.push_back(fmt::format("by {} the body moves by up to {}, {} of its length, more than small "
                                   "strains and turns allow: are load and stiffness what was meant?",
                                   method, length_in_words(largest_displacement),
                                   percent(largest_displacement / length)));
  return warnings;
}

void fail_where_inside_out(const Scene& scene, Answer& answer) {
  constexpr double least = -1, most = 2, share = 0.05; // of an edge; of the body's cells
  const Specimen& body = scene.specimen;
  if (!is_converged(answer.status) || !has_stress(answer.method) || answer.displacement.empty())
    return;
  std::int64_t far = 0;
  double largest = 0;
  FieldsOfCells fields(scene, answer);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      const FieldsOfCells::Values values = fields(cell);
      const Vec3 strain = principal_values(values.strain);
      far += strain[2] <= least || strain[0] >= most ? 1 : 0;
      for (const double stress : values.stress)
        largest = std::max(largest, std::abs(stress));
    }
  const bool is_torn = scene.strain == Strain::finite && !(largest <= greatest_stress);
  if (static_cast<double>(far) <= share * static_cast<double>(body.n_matter_cells()) && !is_torn)
    return;
  answer.status = Status::failed;
  answer.displacement = {};
  answer.reaction.clear();
  answer.strain_energy.reset();
  answer.message =
      is_torn
          ? fmt::format("a stress of {:.3g} Pa, which no matter bears: are the parameters of the law and "
                        "the movement what was meant?",
                        largest)
          : fmt::format("{} of {} cells are turned inside out, or stretched to over {:g} times their length: "
                        "less load or movement, or stiffer tissue",
                        far, body.n_matter_cells(), 1 + most);
}

std::string length_in_words(double metres) {
  const LengthUnit unit = unit_for(std::abs(metres));
  return fmt::format("{:.4g} {}", metres / unit.metres, unit.name);
}

std::string size_in_words(const Scene& scene, const Vec3& size) {
  const LengthUnit unit = unit_for(*std::ranges::max_element(size));
  std::string text;
  for (int a = 0; a < scene.dimension(); ++a)
    text += fmt::format("{}{:.4g}", a > 0 ? " x " : "", size[a] / unit.metres);
  return text + " " + unit.name;
}

namespace {

/// `right-left` for a line, `left` for an arrow, with the deviation; empty without anatomical axes.
std::string in_patient(const Specimen& body, const Vec3& direction, bool is_arrow) {
  constexpr std::array<std::array<const char*, 3>, 3> names{{{"left", "right", "right-left"},
                                                             {"posterior", "anterior", "anterior-posterior"},
                                                             {"inferior", "superior", "inferior-superior"}}};
  if (body.placement.world == WorldAxes::unknown)
    return "";
  const Vec3 world = to_world(body.placement, direction);
  std::size_t most = 0;
  for (std::size_t a = 1; a < 3; ++a)
    most = std::abs(world[a]) > std::abs(world[most]) ? a : most;
  const bool is_ras = body.placement.world == WorldAxes::ras || most == 2;
  const double cosine = std::min(1.0, std::abs(world[most]) / norm(world));
  const double off = std::acos(cosine) * 180 / std::numbers::pi;
  const std::string name = names[most][!is_arrow ? 2 : (world[most] > 0) == is_ras ? 1 : 0];
  return off < 1 ? name : fmt::format("{}, {:.0f} deg off", name, off);
}

/// `x` or `-z` for grid axes, else three numbers.
std::string in_grid(const Vec3& direction, bool is_arrow) {
  const double size = norm(direction);
  for (std::size_t a = 0; a < 3; ++a)
    if (std::abs(direction[a]) > (1 - 1e-9) * size)
      return fmt::format("{}{} of the grid", is_arrow && direction[a] < 0 ? "-" : "", "xyz"[a]);
  return fmt::format("({:.3g}, {:.3g}, {:.3g}) of the grid", direction[0] / size, direction[1] / size,
                     direction[2] / size);
}

/// Mean fibre direction of all cells of matter.
Vec3 mean_fibre(const Specimen& body) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (const Vec3 f = body.fibre_of(cell); body.is_matter(cell))
      sum += Eigen::Vector3d(f[0], f[1], f[2]) * Eigen::RowVector3d(f[0], f[1], f[2]);
  const Eigen::Vector3d mean = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(2);
  return {mean[0], mean[1], mean[2]};
}

/// One line per direction; for an image with partial volume, also its tissue fraction and the tissue at its
/// border.
std::string directions_in_words(const Scene& scene) {
  const Specimen& body = scene.specimen;
  std::string text;
  const auto add = [&](const char* words, const Vec3& direction, bool is_arrow) {
    const std::string patient = in_patient(body, direction, is_arrow), grid = in_grid(direction, is_arrow);
    text += patient.empty() ? fmt::format("\n{} along {}", words, grid)
            : is_arrow      ? fmt::format("\n{} to {} ({})", words, patient, grid)
                            : fmt::format("\n{} along {}: {}", words, grid, patient);
  };
  if (scene.has_fibres())
    add(body.fibres.empty() ? "fibres" : "fibres, on average,",
        body.fibres.empty() ? body.fibre : mean_fibre(body), false);
  if (scene.gravity != Vec3{})
    add("gravity points", scene.gravity, true);
  if (body.tissue.empty() || body.image.empty())
    return text;
  ImageInfo info;
  try {
    info = read_image_info(body.image);
  } catch (const InputError&) { // the file was moved or deleted
    return text;
  }
  const auto blocks = voxel_blocks(info, body);
  if (!blocks)
    return text;
  double cut = 0, all = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const Index3 at = body.grid.cell_at(cell);
    bool is_at_border = false;
    for (int a = 0; a < body.grid.dimension(); ++a) {
      const int first = blocks->first[a] + at[a] * blocks->per_cell[a];
      is_at_border = is_at_border || first <= 0 || first + blocks->per_cell[a] >= info.size[a];
    }
    const double tissue = body.is_matter(cell) ? body.tissue_of(cell) : 0;
    all += tissue;
    cut += is_at_border ? tissue : 0;
  }
  const auto cells = static_cast<double>(body.n_matter_cells());
  text += fmt::format("\ntissue is {} of the volume of its cells", percent(all / cells));
  if (cut > 0)
    text += fmt::format("; {} of it is at the image's border, beyond which is void", percent(cut / all));
  return text;
}

} // namespace

std::string in_words(const Scene& scene, const Plausibility& found) {
  std::string text = "size " + size_in_words(scene, found.size);
  if (found.largest_move > 0)
    text += fmt::format("; largest move {}, {} of the length", length_in_words(found.largest_move),
                        percent(found.move_over_length));
  if (found.mean_strain)
    text += "; mean strain " + percent(*found.mean_strain);
  if (found.strain_of_loads)
    text += "; loads over stiffness " + percent(*found.strain_of_loads);
  return text + directions_in_words(scene);
}

} // namespace maille
