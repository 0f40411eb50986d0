#include "fit/parameters.hpp"

#include "maille/deform/solve.hpp"
#include "maille/scene/frame.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace maille::studies {

namespace {

/// Calls visit(node) for the nodes that errors count: those of the body that nothing prescribes.
template<class Visit>
void for_each_free_node(const Scene& scene, Visit&& visit) {
  const Grid& grid = scene.specimen.grid;
  std::vector<bool> is_prescribed(static_cast<std::size_t>(grid.n_nodes()), false);
  for (const Prescribed& p : scene.prescribed)
    is_prescribed[p.node] = true;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (!is_prescribed[node] && scene.specimen.is_node(grid.node_at(node)))
      visit(node);
}

/// Root of the sum over free nodes of difference(component, node)^2, per component, over the length of the
/// whole reference.
template<class Difference>
Vec3 relative_by_component(const FitCase& one, Difference&& difference) {
  Vec3 sums{};
  double reference = 0;
  for_each_free_node(one.scene, [&](std::int64_t node) {
    for (int b = 0; b < one.scene.dimension(); ++b) {
      const double d = difference(b, node);
      sums[b] += d * d;
      reference += one.reference(b, node) * one.reference(b, node);
    }
  });
  for (double& sum : sums)
    sum = std::sqrt(sum / reference);
  return sums;
}

double largest_cut(const Scene& scene, const Displacement& answer) {
  double cut = 0;
  for (const Prescribed& p : scene.prescribed)
    cut = std::max(cut, std::abs(answer(p.component, p.node) - p.value));
  const double largest = scene.largest_prescribed();
  return largest > 0 ? cut / largest : 0;
}

} // namespace

std::vector<Material> materials_of(std::span<const FitCase> cases) {
  std::vector<Material> all;
  for (const FitCase& one : cases)
    for (const Material& material : one.scene.materials) {
      const auto known = std::ranges::find(all, material.name, &Material::name);
      if (known == all.end())
        all.push_back(material);
      else if (stiffness(known->elasticity) != stiffness(material.elasticity))
        throw std::runtime_error(one.scene.name + ": other constants of " + material.name +
                                 " than in a scene before: give one of the two another name");
    }
  return all;
}

FitError fit_error(const FitCase& one, std::span<const Material> materials, std::string_view method,
                   const Control& control) {
  Scene scene = one.scene;
  for (Material& material : scene.materials) {
    const auto fitted = std::ranges::find(materials, material.name, &Material::name);
    if (fitted == materials.end())
      throw std::runtime_error(scene.name + ": nothing was fitted for its material " + material.name);
    material = *fitted;
  }
  scene.limits = {};
  scene.limits.from = LimitSource::material;
  const Answer answer = deform::solve(scene, method, control);
  FitError error;
  error.status = answer.status;
  if (answer.status == Status::refused || answer.status == Status::failed)
    throw std::runtime_error(scene.name + ": " + std::string(method) + ": " + answer.message);
  error.component = relative_by_component(
      one, [&](int b, std::int64_t node) { return answer.displacement(b, node) - one.reference(b, node); });
  error.relative_l2 = std::hypot(error.component[0], error.component[1], error.component[2]);
  error.cut = answer.status == Status::clamped ? largest_cut(scene, answer.displacement) : 0;
  return error;
}

Vec3 unreachable(const FitCase& one) {
  if (object_frame(one.scene).is_turned)
    return {};
  Vec3 least{}, greatest{};
  for (const Prescribed& p : one.scene.prescribed) {
    const auto b = static_cast<std::size_t>(p.component);
    least[b] = std::min(least[b], p.value);
    greatest[b] = std::max(greatest[b], p.value);
  }
  for (std::size_t b = 0; b < 3; ++b) {
    const bool is_pulled =
        one.scene.gravity[b] != 0 ||
        std::ranges::any_of(one.scene.tractions, [b](const FaceLoad& f) { return f.traction[b] != 0; });
    if (is_pulled) { // nothing bounds where it goes
      least[b] = -INFINITY;
      greatest[b] = INFINITY;
    }
  }
  return relative_by_component(one, [&](int b, std::int64_t node) {
    const auto c = static_cast<std::size_t>(b);
    const double r = one.reference(b, node);
    return r - std::clamp(r, least[c], greatest[c]);
  });
}

double mean_error(std::span<const FitError> errors) {
  double sum = 0;
  for (const FitError& error : errors)
    sum += error.relative_l2 * error.relative_l2;
  return errors.empty() ? 0 : std::sqrt(sum / static_cast<double>(errors.size()));
}

} // namespace maille::studies
