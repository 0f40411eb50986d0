// What fits and identification need of the compiled part: how far a method with other limits is from a
// reference (some thousand times a scene, so the scene is copied once), constants of materials, and measured
// displacements. The searches are maille/_fit.py and maille/_identify.py.

#include "binding.hpp"
#include "maille/deform/solve.hpp"
#include "maille/materials/library.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/warp/displacement_field.hpp"

#include <algorithm>
#include <cmath>

namespace maille::python {

namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// As a material file has it.
py::dict record_of(const Material& material) {
  const ElasticConstants& c = material.elasticity;
  py::dict record;
  record["name"] = material.name;
  record["density"] = material.density;
  record["E"] = c.youngs_modulus;
  record["nu"] = std::array{c.nu12, c.nu13, c.nu23};
  record["G"] = std::array{c.G12, c.G13, c.G23};
  record["is_isotropic"] = c.is_isotropic();
  if (const auto& limits = material.limits) {
    record["stretch"] = limits->stretch;
    record["compress"] = limits->compress;
    record["shear"] = limits->shear;
  }
  record["relaxed_weights"] = material.relaxed_weights;
  if (const auto& known = material.damage) {
    py::dict damage;
    damage["stretch"] = known->stretch;
    damage["compress"] = known->compress;
    damage["shear"] = known->shear;
    damage["of"] = known->of;
    damage["source"] = known->source;
    damage["verified"] = known->verified;
    record["damage"] = damage;
  }
  return record;
}

/// A scene and what is aimed at there. Norms are over the nodes that are neither held nor moved, relative to
/// the reference's whole displacement, so that squares of components add up to that of the whole.
class FitCase {
public:
  /// @param reference  displacement along the grid's axes, one component after the other [m]
  FitCase(const SceneHandle& handle, const Numbers& reference)
      : own_(handle.asked), scene_(handle.scene()), reference_(scene_.specimen.grid) {
    if (reference.size() != std::ssize(reference_.values()))
      throw py::value_error("expected a reference of " + std::to_string(std::ssize(reference_.values())) +
                            " numbers, one a node and component, found " + std::to_string(reference.size()));
    std::copy_n(reference.data(), reference.size(), reference_.values().begin());
    const Grid& grid = scene_.specimen.grid;
    std::vector<bool> is_prescribed(grid.n_nodes(), false);
    for (const Prescribed& p : scene_.prescribed)
      is_prescribed[p.node] = true;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (!is_prescribed[node] && scene_.specimen.is_node(grid.node_at(node))) {
        free_.push_back(node);
        for (int b = 0; b < grid.dimension(); ++b)
          sum_of_reference_ += reference_(b, node) * reference_(b, node);
      }
  }

  /// @param limits   "own", "taut", or "given": those of `numbers`, a row a material of the scene: stretch,
  ///                 compress, shear by rows, relaxed weights
  /// @return status, message, share of each component, the largest part of a move that was cut over the
  ///         largest move
  py::tuple error(const std::string& method, const std::string& limits, const Numbers& numbers, int threads) {
    const SoleUse use(is_used_, "case");
    const bool is_given = limits == "given";
    if (is_given &&
        (numbers.ndim() != 2 || numbers.shape(0) != std::ssize(scene_.materials) || numbers.shape(1) != 18))
      throw py::value_error("expected 18 numbers a material");
    scene_.limits = own_->scene.limits;
    if (limits != "own") {
      scene_.limits = {};
      scene_.limits.from = is_given ? LimitSource::material : LimitSource::taut;
    }
    for (std::size_t m = 0; m < scene_.materials.size(); ++m) {
      Material& material = scene_.materials[m];
      material.limits = own_->scene.materials[m].limits;
      material.relaxed_weights = own_->scene.materials[m].relaxed_weights;
      if (!is_given)
        continue;
      const double* from = numbers.data(static_cast<py::ssize_t>(m), 0);
      material.limits.emplace();
      std::copy_n(from, 3, material.limits->stretch.begin());
      std::copy_n(from + 3, 3, material.limits->compress.begin());
      for (std::size_t a = 0; a < 3; ++a)
        std::copy_n(from + 6 + 3 * a, 3, material.limits->shear[a].begin());
      std::copy_n(from + 15, 3, material.relaxed_weights.begin());
    }
    Steering steering(threads, {}, {}, py::none());
    Answer answer;
    Vec3 component{};
    double cut = 0;
    {
      const py::gil_scoped_release unlocked;
      answer = deform::solve(scene_, method, steering.control());
      if (!answer.displacement.empty())
        component = relative(
            [&](int b, std::int64_t node) { return answer.displacement(b, node) - reference_(b, node); });
      if (answer.status == Status::clamped)
        cut = largest_cut(answer.displacement);
    }
    steering.finish();
    return py::make_tuple(std::string(to_string(answer.status)), answer.message, component, cut);
  }

  /// No limits and no weights do better than this, by component, in units of error(). In both methods a
  /// component by itself stays between the least and the greatest value that is prescribed for it, rest
  /// included: `limits` clamps rest by sums from there, `relaxed` is a mean of neighbours. What the reference
  /// does beyond is lost. 0 for a component that loads pull and where the body turns as a whole.
  Vec3 unreachable() const {
    if (object_frame(scene_).is_turned)
      return {};
    Vec3 least{}, greatest{};
    for (const Prescribed& p : scene_.prescribed) {
      const std::size_t b = p.component;
      least[b] = std::min(least[b], p.value);
      greatest[b] = std::max(greatest[b], p.value);
    }
    for (std::size_t b = 0; b < 3; ++b)
      if (is_pulled(b)) { // nothing bounds where it goes
        least[b] = -INFINITY;
        greatest[b] = INFINITY;
      }
    return relative([&](int b, std::int64_t node) {
      const std::size_t c = b;
      return reference_(b, node) - std::clamp(reference_(b, node), least[c], greatest[c]);
    });
  }

  /// The stress at which the scene's moves just use up taut limits [Pa]; 0 where nothing moves.
  double taut_scale() const {
    Scene taut = own_->scene;
    taut.limits = {};
    taut.limits.from = LimitSource::taut;
    return LinkLimits(taut).taut_scale();
  }

  py::dict record() const {
    py::dict record;
    std::array<bool, 3> is_driven{};
    for (std::size_t b = 0; b < 3; ++b)
      is_driven[b] = is_pulled(b) || std::ranges::any_of(scene_.prescribed, [b](const Prescribed& p) {
                       return static_cast<std::size_t>(p.component) == b && p.value != 0;
                     });
    record["is_driven"] = is_driven;
    const Vec3& fibre = scene_.specimen.fibre;
    record["is_along_grid"] = scene_.specimen.fibres.empty() && std::ranges::count(fibre, 0.0) == 2;
    record["is_along_x"] = fibre[0] != 0;
    record["has_loads"] = scene_.has_loads();
    record["contracts"] = scene_.contracts();
    record["moves"] = !free_.empty() && sum_of_reference_ > 0;
    return record;
  }

  /// With compliances of links along the material's axes: `axial` and `shear` [1/Pa].
  py::list materials() const {
    py::list list;
    for (const Material& material : own_->scene.materials) {
      py::dict record = record_of(material);
      const LinkCompliance compliance = link_compliance(
          reduced_stiffness(stiffness(material.elasticity), scene_.dimension(), scene_.plane));
      record["axial_compliance"] = compliance.axial;
      record["shear_compliance"] = compliance.shear;
      list.append(record);
    }
    return list;
  }

private:
  bool is_pulled(std::size_t b) const {
    return scene_.gravity[b] != 0 ||
           std::ranges::any_of(scene_.tractions, [b](const FaceLoad& face) { return face.traction[b] != 0; });
  }

  template<class Difference>
  Vec3 relative(Difference&& difference) const {
    Vec3 sums{};
    for (const std::int64_t node : free_)
      for (int b = 0; b < scene_.dimension(); ++b) {
        const double d = difference(b, node);
        sums[b] += d * d;
      }
    for (double& sum : sums)
      sum = std::sqrt(sum / sum_of_reference_);
    return sums;
  }

  double largest_cut(const Displacement& answer) const {
    double cut = 0;
    for (const Prescribed& p : scene_.prescribed)
      cut = std::max(cut, std::abs(answer(p.component, p.node) - p.value));
    const double largest = scene_.largest_prescribed();
    return largest > 0 ? cut / largest : 0;
  }

  std::shared_ptr<const SceneAndMeasures> own_;
  Scene scene_;
  Displacement reference_;
  std::vector<std::int64_t> free_;
  double sum_of_reference_ = 0;
  std::atomic<bool> is_used_{false};
};

/// The dimension of a unit of a measure; none for units that no text may have.
std::optional<Dimension> dimension_of(const std::string& unit) {
  if (unit == "m")
    return Dimension::length;
  if (unit == "N")
    return Dimension::force;
  if (unit == "Pa")
    return Dimension::pressure;
  if (unit == "rad")
    return Dimension::angle;
  if (unit.empty())
    return Dimension::dimensionless;
  return std::nullopt;
}

struct Seen {
  std::vector<std::string> names;
  std::vector<int> lines;
  std::vector<double> places, vectors, sigmas; ///< in the world of the body [m]; no sigma: NaN
  std::vector<bool> is_in_body;
  std::int64_t not_finite = 0;

  void add(std::string name, int line, const Vec3& place, const Vec3& vector, double sigma, bool in_body) {
    names.push_back(std::move(name));
    lines.push_back(line);
    places.insert(places.end(), place.begin(), place.end());
    vectors.insert(vectors.end(), vector.begin(), vector.end());
    sigmas.push_back(sigma);
    is_in_body.push_back(in_body);
  }
};

bool has_matter_at(const Specimen& body, const Vec3& world) {
  return !located(body, point_in_object(body.placement, world)).cells.empty();
}

/// Voxels whose middle is in the body; vectors are where the image's header says, in mm.
Seen seen_in_image(const std::string& file, const Scene& scene) {
  Seen seen;
  const DisplacementImage image(file, 1e-3, &scene.specimen);
  const ImageInfo& info = image.info();
  const bool is_of_other_world = read_image_info(file).direction[0] != info.direction[0];
  for (std::int64_t voxel = 0; voxel < info.n_voxels(); ++voxel) {
    const std::int64_t row = voxel / info.size[0];
    const Index3 at{static_cast<int>(voxel % info.size[0]), static_cast<int>(row % info.size[1]),
                    static_cast<int>(row / info.size[1])};
    Vec3 world = info.origin;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t a = 0; a < 3; ++a)
        world[r] += info.direction[r][a] * info.spacing[a] * at[a];
    if (!has_matter_at(scene.specimen, world))
      continue;
    auto u = image.at(world);
    if (u && image.is_along_object())
      u = to_world(scene.specimen.placement, *u);
    else if (u && is_of_other_world)
      u = {-(*u)[0], -(*u)[1], (*u)[2]};
    if (!u)
      ++seen.not_finite;
    else
      seen.add("voxel_" + std::to_string(at[0]) + "_" + std::to_string(at[1]) + "_" + std::to_string(at[2]),
               0, world, *u, NAN, true);
  }
  return seen;
}

py::dict seen_displacements(const SceneHandle& handle, const std::string& file) {
  const Seen seen = made_in_thread([asked = handle.asked, file] {
    if (is_image_file(file))
      return seen_in_image(file, asked->scene);
    Seen points;
    for (const DisplacementPoint& point : read_displacement_points(file))
      points.add("point_" + std::to_string(point.line), point.line, point.place, point.displacement,
                 point.sigma.value_or(NAN), has_matter_at(asked->scene.specimen, point.place));
    return points;
  });
  const auto n = static_cast<py::ssize_t>(seen.names.size());
  py::dict record;
  record["names"] = seen.names;
  record["lines"] = seen.lines;
  record["places"] = Numbers({n, py::ssize_t{3}}, seen.places.data());
  record["vectors"] = Numbers({n, py::ssize_t{3}}, seen.vectors.data());
  record["sigmas"] = Numbers(n, seen.sigmas.data());
  record["is_in_body"] = seen.is_in_body;
  record["not_finite"] = seen.not_finite;
  return record;
}

} // namespace

void bind_fits(py::module_& module) {
  module.def("material", [](const std::string& name) -> py::object {
    const LibraryEntry* entry = find_material(name);
    return entry == nullptr ? py::object(py::none()) : record_of(entry->material);
  });
  module.def("quantity", [](const std::string& text, const std::string& unit) {
    return parse_quantity(text, dimension_of(unit).value_or(Dimension::dimensionless));
  });
  module.def("quantity_in_words", [](const std::string& unit) {
    const auto dimension = dimension_of(unit);
    return dimension ? describe(*dimension) : "a number, in " + unit;
  });
  module.def("is_image_file", [](const std::string& file) { return is_image_file(file); });
  module.def("seen_displacements", &seen_displacements);
  module.def("measure_columns", [](const SceneHandle& handle) {
    std::vector<std::pair<std::string, std::string>> columns;
    for (const Measure& measure : handle.asked->measures)
      for (const std::string& name : measure.columns())
        columns.emplace_back(name, unit_of(measure, handle.scene().dimension()));
    return columns;
  });
  py::class_<FitCase>(module, "FitCase")
      .def(py::init<const SceneHandle&, const Numbers&>())
      .def("error", &FitCase::error)
      .def("unreachable", &FitCase::unreachable)
      .def("taut_scale", &FitCase::taut_scale)
      .def("record", &FitCase::record)
      .def("materials", &FitCase::materials);
}

} // namespace maille::python
