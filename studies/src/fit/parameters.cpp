#include "fit/parameters.hpp"

#include "maille/scene/link_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace maille::studies {

namespace {

/// Slack from this part of the taut one to this many times it; beyond, a link is rigid or feels nothing.
constexpr double range = 1e2;
/// A weight this far from the material's own is no weight of the material any more.
constexpr double range_of_weights = 1e2;
/// Exactly taut limits may cut a move back by rounding.
constexpr double just_above = 1 + 1e-6;

/// The stress at which the most demanding move of the family is taut.
double taut_scale(std::span<const FitCase> cases) {
  double scale = 0;
  for (const FitCase& one : cases) {
    Scene taut = one.scene;
    taut.limits = {};
    taut.limits.from = LimitSource::taut;
    scale = std::max(scale, LinkLimits(taut).taut_scale());
  }
  if (!(scale > 0))
    throw std::runtime_error("nothing to fit limits to: no scene moves one part of the body against another");
  return scale;
}

} // namespace

NeighbourLimits limits_out_of_the_way() {
  NeighbourLimits limits;
  limits.stretch = {2, 2, 2};
  limits.compress = {0, 0, 0};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      limits.shear[a][b] = a == b ? 0 : 1;
  return limits;
}

bool is_along_grid(const Scene& scene) {
  return scene.specimen.fibres.empty() && std::ranges::count(scene.specimen.fibre, 0.0) == 2;
}

bool is_driven(const Scene& scene, int component) {
  const auto b = static_cast<std::size_t>(component);
  return std::ranges::any_of(scene.prescribed,
                             [&](const Prescribed& p) { return p.component == component && p.value != 0; }) ||
         std::ranges::any_of(scene.tractions, [&](const FaceLoad& face) { return face.traction[b] != 0; }) ||
         scene.gravity[b] != 0;
}

FitParameters::FitParameters(std::span<const FitCase> cases, const std::string& method)
    : base_(materials_of(cases)) {
  if (method == "limits") {
    add_limits(cases);
  } else {
    for (std::size_t m = 0; m < base_.size(); ++m) {
      base_[m].limits = limits_out_of_the_way();
      for (std::size_t b = 0; b < static_cast<std::size_t>(cases.front().scene.dimension()); ++b)
        add({Kind::weight, m, b, b}, 1);
    }
  }
  group(cases);
}

void FitParameters::add(const Parameter& parameter, double start) {
  const double spread = std::log(parameter.kind == Kind::weight ? range_of_weights : range);
  // A link that is compressed to nothing has used all of its slack, 1.
  const double most = parameter.kind == Kind::compress ? 0 : std::log(start) + spread;
  parameters_.push_back(parameter);
  start_.push_back(std::min(std::log(start), most));
  low_.push_back(start_.back() - spread);
  high_.push_back(std::min(start_.back() + spread, most));
}

void FitParameters::add_limits(std::span<const FitCase> cases) {
  const Scene& scene = cases.front().scene;
  const auto d = static_cast<std::size_t>(scene.dimension());
  const double scale = taut_scale(cases) * just_above;
  for (std::size_t m = 0; m < base_.size(); ++m) {
    base_[m].limits = NeighbourLimits{};
    const LinkCompliance compliance =
        link_compliance(reduced_stiffness(stiffness(base_[m].elasticity), scene.dimension(), scene.plane));
    for (std::size_t b = 0; b < d; ++b) {
      add({Kind::stretch, m, b, b}, scale * compliance.axial[b]);
      add({Kind::compress, m, b, b}, scale * compliance.axial[b]);
      for (std::size_t a = 0; a < d; ++a)
        if (a != b)
          add({Kind::shear, m, a, b}, scale * compliance.shear[a][b]);
    }
  }
}

void FitParameters::group(std::span<const FitCase> cases) {
  // Along the grid's axes a component knows its own numbers and no others.
  const bool are_apart = std::ranges::all_of(
      cases, [](const FitCase& one) { return is_along_grid(one.scene) && one.scene.specimen.fibre[0] != 0; });
  const auto add_block = [this](const auto& belongs) {
    std::vector<std::size_t> whole;
    for (std::size_t i = 0; i < size(); ++i)
      if (belongs(parameters_[i]))
        whole.push_back(i);
    for (std::size_t m = 0; m < base_.size(); ++m) {
      blocks_of_materials_.emplace_back();
      for (const std::size_t i : whole)
        if (parameters_[i].material == m)
          blocks_of_materials_.back().push_back(i);
    }
    blocks_.push_back(std::move(whole));
  };
  if (!are_apart) {
    add_block([](const Parameter&) { return true; });
    return;
  }
  for (int b = 0; b < cases.front().scene.dimension(); ++b)
    if (std::ranges::any_of(cases, [b](const FitCase& one) { return is_driven(one.scene, b); }))
      add_block([b](const Parameter& p) { return p.component == static_cast<std::size_t>(b); });
}

std::vector<Material> FitParameters::materials(const std::vector<double>& x) const {
  std::vector<Material> materials = base_;
  for (std::size_t i = 0; i < size(); ++i) {
    const auto [kind, m, a, b] = parameters_[i];
    Material& material = materials[m];
    if (kind == Kind::stretch)
      material.limits->stretch[a] = value(i, x);
    else if (kind == Kind::compress)
      material.limits->compress[a] = value(i, x);
    else if (kind == Kind::shear)
      material.limits->shear[a][b] = value(i, x);
    else
      material.relaxed_weights[a] = value(i, x);
  }
  return materials;
}

std::string FitParameters::name(std::size_t i) const {
  const Parameter& p = parameters_[i];
  constexpr std::array<char, 3> axes{'x', 'y', 'z'};
  if (p.kind == Kind::shear)
    return fmt::format("shear[{}][{}]", axes[p.axis], axes[p.component]);
  const char* what = p.kind == Kind::stretch    ? "stretch"
                     : p.kind == Kind::compress ? "compress"
                                                : "relaxed_weights";
  return fmt::format("{}[{}]", what, axes[p.axis]);
}

double FitParameters::value(std::size_t i, const std::vector<double>& x) const {
  const double positive = std::exp(x[i]);
  const Kind kind = parameters_[i].kind;
  return kind == Kind::stretch ? 1 + positive : kind == Kind::compress ? 1 - positive : positive;
}

} // namespace maille::studies
