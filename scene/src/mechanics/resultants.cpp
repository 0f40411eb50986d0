#include "maille/base/vectors.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/sliding.hpp"
#include "mechanics/face_force.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <vector>

namespace maille {

namespace {

/// Sum of forces [N] at places [m], world frame.
class Forces {
public:
  void add(const Vec3& place, const Vec3& force) {
    force_ = plus(force_, force);
    places_.push_back(place);
    forces_.push_back(force);
  }
  /// The force, and the moment about a place.
  Resultant about(const Vec3& centroid) const {
    Resultant resultant;
    resultant.centroid = centroid;
    resultant.force = force_;
    for (std::size_t i = 0; i < places_.size(); ++i)
      resultant.moment = plus(resultant.moment, cross(minus(places_[i], centroid), forces_[i]));
    return resultant;
  }

private:
  Vec3 force_{};
  std::vector<Vec3> places_, forces_;
};

/// Mean of places.
class Middle {
public:
  void add(const Vec3& place, double weight = 1) {
    sum_ = plus(sum_, times(weight, place));
    weight_ += weight;
  }
  Vec3 place() const { return {sum_[0] / weight_, sum_[1] / weight_, sum_[2] / weight_}; }

private:
  Vec3 sum_{};
  double weight_ = 0;
};

/// Places for lever arms, world frame: positions of nodes in the state in which forces are in balance.
class Places {
public:
  Places(const Scene& scene, const Answer& answer)
      : scene_(scene), answer_(answer), is_deformed_(is_of_finite_strain(scene, answer)),
        frame_(is_deformed_ ? Frame{} : object_frame(scene)) {}

  Vec3 operator()(std::int64_t node) const {
    Vec3 x = scene_.specimen.position(scene_.specimen.grid.node_at(node));
    if (is_deformed_)
      for (int b = 0; b < scene_.dimension(); ++b)
        x[b] += answer_.displacement(b, node);
    else if (frame_.is_turned)
      x = plus(x, frame_.in_world(x, {}));
    return plus(scene_.specimen.placement.origin, in_world(x));
  }
  /// Mean of a cell's corners, or of the corners of one face.
  Vec3 middle(std::int64_t cell, const FaceLoad* face = nullptr) const {
    const Grid& grid = scene_.specimen.grid;
    Middle middle;
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner)
      if (face == nullptr || (corner >> face->axis & 1) == (face->upper ? 1 : 0))
        middle.add((*this)(grid.corner(grid.cell_at(cell), corner)));
    return middle.place();
  }
  Vec3 in_world(const Vec3& vector) const { return to_world(scene_.specimen.placement, vector); }
  /// The force of a load on its face, in the world.
  Vec3 force(const FaceLoad& load) const { return in_world(force_on_face(scene_, answer_, load)); }

private:
  const Scene& scene_;
  const Answer& answer_;
  bool is_deformed_;
  Frame frame_;
};

void name(const Scene& scene, std::int32_t condition, const char* otherwise, Resultant& resultant) {
  resultant.name = otherwise;
  if (condition >= 0 && static_cast<std::size_t>(condition) < scene.conditions.size()) {
    resultant.name = scene.conditions[condition].name;
    resultant.where = scene.conditions[condition].where;
  }
}

/// Resultants of holds, or of moves. A node of two conditions counts for the first.
std::vector<Resultant> of_prescribed(const Scene& scene, const Answer& answer, const Places& places,
                                     bool held) {
  struct Region {
    Forces forces;
    std::vector<std::int64_t> nodes;
  };
  std::map<std::int32_t, Region> regions;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i) {
    const Prescribed& p = scene.prescribed[i];
    if (p.held != held)
      continue;
    Vec3 force{};
    force[p.component] = answer.reaction[i];
    Region& region = regions[p.condition];
    region.forces.add(places(p.node), places.in_world(force));
    region.nodes.push_back(p.node);
  }
  std::vector<Resultant> resultants;
  for (auto& [condition, region] : regions) {
    std::ranges::sort(region.nodes);
    region.nodes.erase(std::unique(region.nodes.begin(), region.nodes.end()), region.nodes.end());
    Middle centroid;
    for (const std::int64_t node : region.nodes)
      centroid.add(places(node));
    resultants.push_back(region.forces.about(centroid.place()));
    name(scene, condition, held ? "hold" : "move", resultants.back());
  }
  return resultants;
}

/// Adds the springs, by condition.
void add_springs(const Scene& scene, const Answer& answer, const Places& places,
                 std::vector<Resultant>& resultants) {
  std::set<std::int32_t> conditions;
  for (const FaceSpring& spring : scene.springs)
    conditions.insert(spring.condition);
  for (const std::int32_t condition : conditions) {
    Forces forces;
    Middle centroid;
    for (const SpringPull& pull : pulls_of_springs(scene, answer, condition)) {
      forces.add(places(pull.node), places.in_world(pull.force));
      centroid.add(places(pull.node), pull.stiffness);
    }
    resultants.push_back(forces.about(centroid.place()));
    name(scene, condition, "foundation", resultants.back());
  }
}

std::vector<Resultant> of_loads(const Scene& scene, const Answer& answer, const Places& places) {
  struct Region {
    Forces forces;
    Middle centroid;
  };
  const Specimen& body = scene.specimen;
  std::map<std::int32_t, Region> regions;
  for (const FaceLoad& load : scene.tractions) {
    Region& region = regions[load.condition];
    const Vec3 middle = places.middle(load.cell, &load);
    region.forces.add(middle, places.force(load));
    region.centroid.add(middle, face_area(body.grid, load.axis));
  }
  std::vector<Resultant> resultants;
  for (const auto& [condition, region] : regions) {
    resultants.push_back(region.forces.about(region.centroid.place()));
    name(scene, condition, "load", resultants.back());
  }
  add_springs(scene, answer, places, resultants);
  if (scene.gravity == Vec3{0, 0, 0})
    return resultants;
  Middle centroid;
  const double volume = cell_volume(body.grid);
  double mass = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      const double of_cell = volume * body.tissue_of(cell) * scene.materials[body.material(cell)].density;
      centroid.add(places.middle(cell), of_cell);
      mass += of_cell;
    }
  Resultant& weight = resultants.emplace_back();
  weight.name = "gravity";
  weight.centroid = centroid.place();
  weight.force = times(mass, places.in_world(scene.gravity));
  return resultants;
}

} // namespace

Mechanics resultants_of(const Scene& scene, const Answer& answer) {
  const Places places(scene, answer);
  Mechanics mechanics;
  if (answer.reaction.size() == scene.prescribed.size()) {
    mechanics.holds = of_prescribed(scene, answer, places, true);
    mechanics.moves = of_prescribed(scene, answer, places, false);
  }
  mechanics.loads = of_loads(scene, answer, places);
  return mechanics;
}

Vec3 total_force(const std::vector<Resultant>& resultants) {
  Vec3 total{};
  for (const Resultant& resultant : resultants)
    total = plus(total, resultant.force);
  return total;
}

std::string_view mechanics_conventions() {
  return R"(SI units: m, N, N m, Pa, J; in 2D all forces, moments and energies are per metre of thickness, in 1D the
body is a bar of 1 m^2. All vectors are in the world's frame.
Forces and moments act on the body: one that is pulled towards +x is moved by a force towards +x and held by
one towards -x. A moment is about the centroid of its region: the mean of its nodes, of a load that of its
faces, of gravity that of the mass. Lever arms are those of the body at rest, carried along where moves turn
all of it; with strain = "finite" those of the deformed body. A node that two holds or two moves ask for
counts with the first. Contracting fibres pull inside the body, with neither a force nor a moment.
Strain and stress are one value a cell, its mean. Strain > 0 is longer, stress > 0 is a pull, pressure is
minus a third of the trace of stress: > 0 where matter is pressed together. Fibre strain and fibre stress are
a.E.a and a.S.a, a the fibre's direction, the stress of its contraction included. Largest and smallest strain
are the principal ones. With strain = "finite" strain is Biot's, U - I, and stress Cauchy's, per deformed
area, both in the frame of the cell; nominal stress, per area at rest, is the one whose work is on U - I.
Every cell counts by its volume at rest; a percentile is the least of the cells' values that so much of the
volume does not exceed.
Volumes are those of hexahedra whose corners are the nodes. Strain energy is elastic, each cell's by what the
method minimises: of coupled the lattice's, of finite elements the integral over the element.
)";
}

} // namespace maille
