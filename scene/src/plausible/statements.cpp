// Figures of the settings of a scene, and warnings about settings without effect or easily misread. Uses only
// the Scene, so that `check`, `run` and Python agree.
#include "maille/base/vectors.hpp"
#include "maille/plugins/open_plugin.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace maille {

namespace {

constexpr double least_modulus = 100, greatest_modulus = 1e12, least_density = 500, greatest_density = 25000;
/// Limit of small rotations [rad]: the energy is off by a third, and the error grows with the square.
constexpr double largest_small_turn = 15 * std::numbers::pi / 180;
/// Smallest shares of the mean cross-section: below, a test's plate is uneven, a face's hold or move tiny.
constexpr double least_plate = 0.8, least_face = 0.05;
/// Share of a sliding border's nodes above which one hold or move locks both sides together.
constexpr double most_of_border = 0.5;

/// Extent and values of one of Scene::conditions.
struct Stated {
  std::set<std::int64_t> nodes;
  std::array<std::array<double, 2>, 3> area{}; ///< of outer faces, by their axis and side [m^2]
  std::int64_t n_faces = 0;
  bool is_load = false, is_held = false;
  double most = 0; ///< displacement, traction or stiffness of springs
};

void add_face(const Grid& grid, const Index3& cell, std::size_t axis, bool upper, Stated& stated) {
  stated.area[axis][upper ? 1 : 0] += face_area(grid, int(axis));
  ++stated.n_faces;
  for (int corner = 0; corner < grid.corners_per_cell(); ++corner)
    if ((corner >> axis & 1) == (upper ? 1 : 0))
      stated.nodes.insert(grid.corner(cell, corner));
}

/// Adds the outer faces of a plate: those whose corners are all among its nodes.
void add_outer_faces(const Specimen& body, Stated& stated) {
  std::set<std::int64_t> cells;
  for (const std::int64_t node : stated.nodes)
    body.for_each_cell_at(body.grid.node_at(node), [&](std::int64_t cell) { cells.insert(cell); });
  for (const std::int64_t cell : cells)
    for (int side = 0; side < 2 * body.grid.dimension(); ++side) {
      Index3 beyond = body.grid.cell_at(cell);
      const auto axis = std::size_t(side / 2);
      beyond[axis] += side % 2 ? 1 : -1;
      if (body.grid.has_cell(beyond) && body.is_matter(body.grid.cell(beyond)))
        continue;
      bool is_in = true;
      for (int corner = 0; corner < body.grid.corners_per_cell() && is_in; ++corner)
        is_in = (corner >> axis & 1) != side % 2 ||
                stated.nodes.contains(body.grid.corner(body.grid.cell_at(cell), corner));
      if (is_in)
        stated.area[axis][side % 2 ? 1 : 0] += face_area(body.grid, int(axis));
    }
}

std::vector<Stated> stated_of(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  std::vector<Stated> all(scene.conditions.size());
  const auto at = [&](std::int32_t condition) {
    return condition >= 0 && condition < std::ssize(all) ? &all[condition] : nullptr;
  };
  for (const Prescribed& p : scene.prescribed)
    if (Stated* stated = at(p.condition)) {
      stated->nodes.insert(p.node);
      stated->is_held = p.held;
      stated->most = std::max(stated->most, std::abs(p.value));
    }
  for (Stated& stated : all)
    add_outer_faces(scene.specimen, stated);
  for (const FaceLoad& load : scene.tractions)
    if (Stated* stated = at(load.condition)) {
      add_face(grid, grid.cell_at(load.cell), std::size_t(load.axis), load.upper, *stated);
      stated->is_load = true;
      stated->most = std::max(stated->most, norm(load.traction));
    }
  for (const FaceSpring& spring : scene.springs)
    if (Stated* stated = at(spring.condition)) {
      add_face(grid, grid.cell_at(spring.cell), std::size_t(spring.axis), spring.upper, *stated);
      stated->is_load = true;
      stated->most = spring.stiffness;
    }
  return all;
}

/// The mean area of the layers across each axis [m^2].
Vec3 cross_sections(const Specimen& body) {
  const double cells = static_cast<double>(body.n_matter_cells());
  Vec3 area{};
  for (std::size_t a = 0; a < std::size_t(body.grid.dimension()); ++a)
    area[a] = cells * face_area(body.grid, int(a)) / body.grid.cells()[a];
  return area;
}

StatedPart part_of(const Stated& stated, const NamedCondition& asked, const Vec3& sections) {
  StatedPart part{asked.name, asked.where, std::ssize(stated.nodes)};
  for (std::size_t a = 0; a < 3; ++a)
    for (const double area : stated.area[a]) {
      part.area += area;
      if (sections[a] > 0)
        part.share = std::max(part.share, area / sections[a]);
    }
  return part;
}

/// Rotation of the nodes of a move relative to the frame of strains [rad].
double turn_of(const Scene& scene, std::int32_t condition, const Frame& object) {
  std::map<std::int64_t, std::pair<Vec3, int>> nodes;
  for (const Prescribed& p : scene.prescribed)
    if (p.condition == condition) {
      auto& [u, n] = nodes[p.node];
      u[p.component] = p.value;
      ++n;
    }
  std::vector<Vec3> rest, displacement;
  for (const auto& [node, moved] : nodes)
    if (moved.second == scene.dimension()) {
      rest.push_back(scene.specimen.position(scene.specimen.grid.node_at(node)));
      displacement.push_back(moved.first);
    }
  if (rest.size() < 2)
    return 0;
  const Frame own = fit_frame(scene.dimension(), rest, displacement);
  return Eigen::AngleAxisd(Eigen::Matrix3d(object.rotation.transpose() * own.rotation)).angle();
}

bool is_at_rest(const RigidPose& pose) {
  return norm(pose.shift) < 1e-12 && std::abs(pose.rotation[0]) > 1 - 1e-12;
}

class Warnings {
public:
  explicit Warnings(const Scene& scene) : scene_(scene), stated_(stated_of(scene)) {
    for (const Prescribed& p : scene.prescribed)
      ++n_fixed_[p.node];
  }

  std::vector<std::string> all() {
    for (const LeftOutPiece& piece : scene_.left_out)
      if (piece.cells >= 0)
        warn("{}{}", piece.cells > 0 ? "left out, as nothing holds it: " : "", piece.name);
    const Vec3 sections = cross_sections(scene_.specimen);
    for (std::size_t i = 0; i < stated_.size(); ++i)
      about_region(static_cast<std::int32_t>(i), part_of(stated_[i], scene_.conditions[i], sections));
    if (has_load_beside_test(scene_))
      warn("[test] beside loads: its stiffness and its modulus are of both, not of the material");
    about_turns();
    about_time();
    about_sliding();
    about_materials();
    about_directions();
    return std::move(found_);
  }

private:
  template<class... Parts>
  void warn(fmt::format_string<Parts...> format, Parts&&... parts) {
    found_.push_back(fmt::format(format, std::forward<Parts>(parts)...));
  }

  void about_region(std::int32_t condition, const StatedPart& part) {
    const Stated& of = stated_[condition];
    const bool is_move = !of.is_load && !of.is_held, is_drive = part.name.starts_with("drive");
    if (part.nodes == 0) {
      warn("{} has no effect: other conditions, or pieces that are left out, have all its nodes", part.name);
      return;
    }
    const double least = of.is_load ? 0 : 1e-9 * scene_.specimen.grid.spacing()[0]; // for 360-degree turns
    if (of.most <= least && (of.is_load || is_move) && !is_drive && !scene_.test)
      warn("{} is zero: {}", part.name, of.is_load ? "it loads nothing" : "it holds where it is");
    if (of.is_load && std::ranges::all_of(of.nodes, [&](std::int64_t node) {
          const auto fixed = n_fixed_.find(node);
          return fixed != n_fixed_.end() && fixed->second == scene_.dimension();
        }))
      warn("{} acts on nodes that are held or moved: it changes nothing but the forces there", part.name);
    if (scene_.dimension() > 1 && of.is_load && of.n_faces == 1)
      warn("{} acts on the face of a single cell: displacements there depend on the spacing", part.name);
    if (scene_.dimension() > 1 && is_move && part.nodes == 1)
      warn("{} moves a single node: its force depends on the spacing, and is 0 for small ones; a region of "
           "2 to 3 cells has a force of its own",
           part.name);
    const bool is_plate = scene_.test && (is_move ? scene_.test->kind != TestKind::indent : condition == 0);
    const bool is_face = part.where.size() > 1 && part.where.front() != '{' && !is_drive && !scene_.test;
    if (part.share < (is_plate ? least_plate : is_face && part.nodes > 1 ? least_face : 0))
      warn("{}{}{} touches {} nodes, {:.2g} % of the body's mean cross-section: of an uneven end only the "
           "outermost plane",
           part.name, part.where.empty() ? "" : " at ", part.where, part.nodes, 100 * part.share);
  }

  void about_turns() {
    if (in_blocks(scene_))
      return;
    const Frame object = object_frame(scene_);
    double most = 0;
    std::string name;
    for (std::size_t i = 0; i < stated_.size(); ++i)
      if (!stated_[i].is_load && !stated_[i].is_held && stated_[i].most > 0)
        if (const double turn = turn_of(scene_, static_cast<std::int32_t>(i), object); turn > most) {
          most = turn;
          name = scene_.conditions[i].name;
        }
    for (const Drive& drive : scene_.drives)
      for (const RigidPose& pose : drive.poses)
        if (const double turn = 2 * std::acos(std::min(1.0, std::abs(pose.rotation[0]))); turn > most) {
          most = turn;
          name = "a drive";
        }
    if (most > largest_small_turn * (1 + 1e-9))
      warn("{} turns by {:.3g} degrees: small strain is good up to some 15; strain = \"finite\" has no such "
           "bound",
           name, most * 180 / std::numbers::pi);
  }

  void about_time() {
    constexpr const char* end = "answers are of the end; --steps N has the times before it";
    for (const Drive& drive : scene_.drives)
      if (!drive.poses.empty() && is_at_rest(drive.poses.back()))
        warn("a drive ends where it began: {}", end);
    for (const TimedContraction& timed : scene_.timed)
      if (timed.course.at(1) == 0)
        warn("a contraction ends at 0 by its course: {}", end);
    if (scene_.timed.empty() && scene_.contracts() &&
        std::ranges::all_of(scene_.active_stress, [](double stress) { return stress == 0; }))
      warn("a contraction of 0 pulls at nothing");
    else if (scene_.dimension() == 2 && scene_.contracts() && pulls_across_the_plane())
      warn("the contraction has no effect: its fibres lie across the plane, and plane strain keeps that "
           "fixed");
  }

  bool pulls_across_the_plane() const {
    double along = 0, all = 0;
    for (std::int64_t cell = 0; cell < scene_.specimen.grid.n_cells(); ++cell)
      if (scene_.specimen.is_matter(cell)) {
        all = std::max(all, scene_.active_stress[cell]);
        along = std::max(along, scene_.cell_active_stress(cell).cwiseAbs().maxCoeff());
      }
    return along < 1e-9 * all;
  }

  void about_sliding() {
    const Specimen& body = scene_.specimen;
    for (const SlidingBorder& border : scene_.sliding) {
      double n_nodes = 0;
      std::vector<double> n_kept(stated_.size());
      for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
        std::set<std::int32_t> labels;
        body.for_each_cell_at(body.grid.node_at(node),
                              [&](std::int64_t cell) { labels.insert(body.label[cell]); });
        if (!labels.contains(border.one) || !labels.contains(border.other))
          continue;
        ++n_nodes;
        for (std::size_t i = 0; i < stated_.size(); ++i)
          n_kept[i] += !stated_[i].is_load && stated_[i].nodes.contains(node) ? 1 : 0;
      }
      for (std::size_t i = 0; i < stated_.size(); ++i)
        if (n_kept[i] > most_of_border * n_nodes)
          warn("{} has {} of {} nodes of the border of labels {} and {}: both sides stay together there, and "
               "do not slide",
               scene_.conditions[i].name, n_kept[i], n_nodes, border.one, border.other);
    }
  }

  void about_materials() {
    for (const MaterialSummary& material : materials_of(scene_)) {
      if (material.least < least_modulus || material.most > greatest_modulus)
        warn("{}: Young's modulus {:.3g} to {:.3g} Pa: is it in the unit that was meant?", material.name,
             material.least, material.most);
      if (material.density < least_density || material.density > greatest_density)
        warn("{}: density {:.4g} kg/m^3: is it in the unit that was meant?", material.name, material.density);
    }
    for (const Material& material : scene_.materials)
      if (material.law && scene_.strain != Strain::finite)
        warn("{}: its law has no effect without strain = \"finite\": it is as stiff as at rest{}",
             material.name, std::holds_alternative<Muscle>(*material.law) ? ", and passive" : "");
  }

  void about_directions() {
    const Specimen& body = scene_.specimen;
    const Vec3 gravity = to_world(body.placement, scene_.gravity);
    if (body.placement.world != WorldAxes::unknown && gravity[2] > 0.7 * norm(gravity))
      warn("gravity points to superior, so it lifts the body: `frame` says whose axes it is along");
    const FibreReport& fibres = body.fibre_report;
    if (5 * fibres.without_direction() > fibres.cells)
      warn("fibres: {} of {} cells have no direction of their own, and take others'",
           fibres.without_direction(), fibres.cells);
  }

  const Scene& scene_;
  std::vector<Stated> stated_;
  std::map<std::int64_t, int> n_fixed_; ///< components, by node
  std::vector<std::string> found_;
};

} // namespace

std::vector<StatedPart> stated_parts(const Scene& scene) {
  const std::vector<Stated> stated = stated_of(scene);
  const Vec3 sections = cross_sections(scene.specimen);
  std::vector<StatedPart> parts;
  for (std::size_t i = 0; i < stated.size(); ++i)
    parts.push_back(part_of(stated[i], scene.conditions[i], sections));
  return parts;
}

std::vector<MaterialSummary> materials_of(const Scene& scene) {
  const Specimen& body = scene.specimen;
  std::vector<MaterialSummary> materials(scene.materials.size());
  std::vector<double> least(scene.materials.size(), INFINITY), most(scene.materials.size(), 0);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (const std::uint8_t m = body.material(cell); m < materials.size()) {
      least[m] = std::min(least[m], body.stiffness_ratio_of(cell));
      most[m] = std::max(most[m], body.stiffness_ratio_of(cell));
    }
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const Material& material = scene.materials[m];
    const auto [soft, stiff] = std::ranges::minmax(material.elasticity.youngs_modulus);
    const bool is_in_body = most[m] > 0;
    materials[m] = {material.name, soft * (is_in_body ? least[m] : 1), stiff * (is_in_body ? most[m] : 1),
                    material.density, "none needed"};
    if (material.elasticity.is_isotropic() && !scene.contracts())
      continue;
    const Vec3 along = to_world(body.placement, body.fibre);
    materials[m].fibre = body.fibres.empty() ? fmt::format("along ({:.3g}, {:.3g}, {:.3g}) of the world",
                                                           along[0] + 0.0, along[1] + 0.0, along[2] + 0.0)
                         : body.fibre_report.source.empty() ? "a direction each cell"
                                                            : "by " + body.fibre_report.source;
  }
  return materials;
}

std::vector<std::string> statement_warnings(const Scene& scene) {
  return Warnings(scene).all();
}

std::vector<std::string> unused_settings(const Scene& scene, const std::vector<std::string>& methods) {
  const RelaxationSettings &asked = scene.relaxation, usual;
  struct Setting {
    bool is_asked;
    std::string_view words;
    std::vector<std::string> methods;
  };
  const std::array<Setting, 4> settings{{
      {asked.mode != usual.mode, "[relaxation] mode = \"deformable\"", {"sweep", "relaxed"}},
      {asked.sweeps != usual.sweeps, "[relaxation] sweeps", {"sweep"}},
      {asked.extrapolation != usual.extrapolation, "[relaxation] extrapolation = \"nested\"", {"coupled"}},
      {scene.strain == Strain::finite, "strain = \"finite\"", {"coupled", "fem_q1", "fem_q2", "calculix"}},
  }};
  std::vector<std::string> unused;
  const bool is_moved =
      std::ranges::any_of(scene.prescribed, [](const Prescribed& p) { return !p.held || p.value != 0; });
  if (!is_moved && !scene.has_loads() && scene.drives.empty() && !scene.test)
    unused.push_back("nothing moves or loads the body: it stays at rest");
  if (scene.limits.cut_is_allowed && scene.limits.from == LimitSource::none)
    unused.push_back("[limits] cut = \"allowed\" has no effect: the scene asks for no limits");
  for (const Setting& setting : settings)
    if (setting.is_asked && std::ranges::none_of(methods, [&](const std::string& method) {
          return std::ranges::find(setting.methods, method) != setting.methods.end();
        }))
      unused.push_back(fmt::format("{} has no effect here: it is of {}", setting.words,
                                   fmt::join(setting.methods, " and ")));
  return unused;
}

std::vector<std::string> world_warnings(const WorldScene& world) {
  std::vector<std::string> warnings;
  const bool takes_factors = world.contact == ContactLaw::surfaces && world.dimension == 3 &&
                             std::ranges::any_of(world.objects, [](const WorldObject& object) {
                               return object.kind == ObjectKind::deformable;
                             });
  if (takes_factors && !has_plugin("maille-cholmod.so"))
    warnings.push_back("maille-cholmod.so is not there: multigrid takes the place of factors of bodies in "
                       "contact, many times as slow");
  for (const WorldObject& object : world.objects) {
    for (std::string warning : plausibility(object.scene).warnings) {
      constexpr std::string_view of_scenes = "strain = \"finite\""; // a key that worlds do not have
      if (const std::size_t at = warning.find(of_scenes); at != std::string::npos)
        warning.replace(at, of_scenes.size(), "relaxation = { frame = \"blocks\" } and contact = \"cells\"");
      warnings.push_back(object.name + ": " + warning);
    }
    if (const double factor = stiffening_of_relaxed(object.scene);
        world.method == "relaxed" && object.kind == ObjectKind::deformable && factor > largest_stiffening)
      warnings.push_back(
          fmt::format("{}: forces of `relaxed` are of matter up to {:.3g} times as stiff, and mean "
                      "nothing here; `coupled` has the Poisson effect",
                      object.name, factor));
    if (world.contact != ContactLaw::surfaces || world.is_open || object.kind == ObjectKind::fixed)
      continue;
    const Specimen& body = object.scene.specimen;
    const Eigen::AngleAxisd turn(object.turn_angle,
                                 Eigen::Map<const Eigen::Vector3d>(object.turn_axis.data()));
    Eigen::AlignedBox3d box;
    for (int corner = 0; corner < 8; ++corner) {
      const Index3 last{corner & 1 ? body.grid.nodes()[0] - 1 : 0, corner & 2 ? body.grid.nodes()[1] - 1 : 0,
                        corner & 4 ? body.grid.nodes()[2] - 1 : 0};
      const Vec3 x = body.position(last);
      box.extend(turn * Eigen::Vector3d(x[0], x[1], x[2]) +
                 Eigen::Map<const Eigen::Vector3d>(object.position.data()));
    }
    for (int a = 0; a < world.dimension; ++a) {
      const auto axis = std::size_t(a);
      const double h = world.spacing[axis];
      const bool is_low = box.min()[a] < 1e-6 * h;
      if (is_low || box.max()[a] > (world.cells[axis] - 1e-6) * h)
        warnings.push_back(
            fmt::format("{}: it lies at the world's border {}{}, a wall: forces there count as "
                        "contact; a cell between the two leaves them out",
                        object.name, "xyz"[axis], is_low ? '-' : '+'));
    }
  }
  return warnings;
}

} // namespace maille
