#include "maille/scene/plausibility.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>

namespace maille {

namespace {

/// Stores the first unusable number.
class Finder {
public:
  /// Checks a number with a unit.
  template<class Name>
  void look_at_size(double value, const Name& name) {
    look_at(value, name);
    const double size = std::abs(value);
    if (found_.empty() && size > 0 && (size < least_usable || size > greatest_usable))
      found_ = fmt::format("{} is {}, and sizes must be from {} to {} in SI units, or 0", name(), value,
                           least_usable, greatest_usable);
  }
  void look_at_sizes(const Vec3& values, const char* name) {
    for (std::size_t a = 0; a < 3; ++a)
      look_at_size(values[a], [&] { return fmt::format("{} along {}", name, "xyz"[a]); });
  }
  template<class Name>
  void look_at(double value, const Name& name) {
    if (found_.empty() && !std::isfinite(value))
      found_ = fmt::format("{} is {}", name(), value);
  }
  void look_at(const Vec3& values, const char* name) {
    for (std::size_t a = 0; a < 3; ++a)
      look_at(values[a], [&] { return fmt::format("{} along {}", name, "xyz"[a]); });
  }
  void say(std::string text) {
    if (found_.empty())
      found_ = std::move(text);
  }
  std::string take() { return std::move(found_); }

private:
  std::string found_;
};

void look_at(Finder& finder, const NeighbourLimits& limits, const std::string& of) {
  for (std::size_t a = 0; a < 3; ++a) {
    finder.look_at(limits.stretch[a], [&] { return "a largest distance of " + of; });
    finder.look_at(limits.compress[a], [&] { return "a smallest distance of " + of; });
    for (std::size_t b = 0; b < 3; ++b)
      if (a != b) // the diagonal is no shear
        finder.look_at(limits.shear[a][b], [&] { return "a largest shear of " + of; });
  }
}

void look_at(Finder& finder, const Material& material) {
  const ElasticConstants& c = material.elasticity;
  for (const double ratio : {c.nu12, c.nu13, c.nu23})
    finder.look_at(ratio, [&] { return "a Poisson ratio of " + material.name; });
  for (const double modulus :
       {c.youngs_modulus[0], c.youngs_modulus[1], c.youngs_modulus[2], c.G12, c.G13, c.G23})
    finder.look_at_size(modulus, [&] { return "a modulus of " + material.name; });
  finder.look_at_size(material.density, [&] { return "the density of " + material.name; });
  for (const double weight : material.relaxed_weights)
    finder.look_at(weight, [&] { return "a weight of " + material.name; });
  if (material.limits)
    look_at(finder, *material.limits, material.name);
}

void look_at_body(Finder& finder, const Specimen& body) {
  if (body.grid.n_cells() < 1 || body.n_matter_cells() < 1)
    finder.say("the body has no cells");
  finder.look_at_sizes(body.grid.spacing(), "the spacing");
  for (int a = 0; a < body.grid.dimension(); ++a)
    if (!(body.grid.spacing()[a] > 0))
      finder.say(fmt::format("the spacing along {} is {}", "xyz"[a], body.grid.spacing()[a]));
  finder.look_at(body.origin, "the origin");
  finder.look_at(body.fibre, "the fibre");
  for (const auto& fibre : body.fibres)
    for (const float component : fibre)
      finder.look_at(static_cast<double>(component), [] { return "the fibre of a cell"; });
  for (const float part : body.tissue)
    if (!(part >= 0 && part <= 1))
      finder.say(fmt::format("the part of a cell that is tissue is {}", part));
  for (const float ratio : body.stiffness_ratio)
    if (finder.look_at_size(double{ratio}, [] { return "the stiffness ratio of a cell"; }); !(ratio > 0))
      finder.say(fmt::format("the stiffness ratio of a cell is {}", ratio));
}

void look_at_loads(Finder& finder, const Scene& scene) {
  finder.look_at_sizes(scene.gravity, "gravity");
  for (const FaceLoad& load : scene.tractions)
    finder.look_at_sizes(load.traction, "a traction");
  for (const FaceSpring& spring : scene.springs) {
    finder.look_at_size(spring.stiffness, [] { return "a stiffness of springs"; });
    finder.look_at(spring.direction, "the direction of a spring");
  }
  for (const double stress : scene.active_stress)
    finder.look_at_size(stress, [] { return "the active stress of a cell"; });
}

} // namespace

std::string unusable_number(const Scene& scene) {
  Finder finder;
  look_at_body(finder, scene.specimen);
  for (const Material& material : scene.materials)
    look_at(finder, material);
  for (const Prescribed& p : scene.prescribed)
    finder.look_at(p.value, [] { return "a prescribed displacement"; });
  finder.look_at_size(scene.largest_prescribed(), [] { return "the largest prescribed displacement"; });
  look_at_loads(finder, scene);
  if (scene.limits.from == LimitSource::given)
    look_at(finder, scene.limits.given, "the scene");
  if (scene.limits.taut_scale)
    finder.look_at(*scene.limits.taut_scale, [] { return "the scale of taut limits"; });
  finder.look_at(scene.relaxation.tolerance, [] { return "the tolerance"; });
  return finder.take();
}

} // namespace maille
