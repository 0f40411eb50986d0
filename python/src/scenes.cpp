// Scenes, and what is asked of them.

#include "binding.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/solve.hpp"
#include "maille/images/image.hpp"
#include "maille/images/write_image.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"

#include <algorithm>

namespace maille::python {

namespace {

using Nodes = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;
using Labels = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

SceneHandle handle_of(SceneAndMeasures asked) {
  for (std::string& warning : file_warnings(true))
    asked.scene.left_out.push_back({0, std::move(warning)}); // one of the question's warnings
  return {std::make_shared<const SceneAndMeasures>(std::move(asked))};
}

using AddLabels = std::function<void(SceneBuilder&)>;

/// Labels with any strides, copied when the builder is given; nothing where the array has another type.
template<class Label>
AddLabels labels_of(const py::array& array, const Affine& affine) {
  if (!py::isinstance<py::array_t<Label>>(array))
    return {};
  ArrayLayout layout;
  std::int64_t least = 0, most = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    layout.size[a] = static_cast<int>(array.shape(static_cast<py::ssize_t>(a)));
    layout.stride[a] = array.strides(static_cast<py::ssize_t>(a)) / static_cast<std::int64_t>(sizeof(Label));
    const std::int64_t reach = layout.stride[a] * (layout.size[a] - 1);
    (reach < 0 ? least : most) += reach;
  }
  layout.first = -least;
  const auto* const first = static_cast<const Label*>(array.data()) + least;
  return [=, n = static_cast<std::size_t>(most - least + 1)](SceneBuilder& builder) {
    builder.labels(std::span(first, n), layout, affine);
  };
}

void put(const py::handle& value, toml::array& into);

toml::table table_of(const py::dict& from) {
  toml::table table;
  toml::array one;
  for (const auto& [key, value] : from) {
    one.clear();
    put(value, one);
    one[0].visit([&](auto& node) { table.insert(key.cast<std::string>(), std::move(node)); });
  }
  table.is_inline(true); // as it stands in messages
  return table;
}

/// What maille._toml.plain leaves: truths, numbers, texts, lists and tables.
void put(const py::handle& value, toml::array& into) {
  if (py::isinstance<py::bool_>(value))
    into.push_back(value.cast<bool>());
  else if (py::isinstance<py::int_>(value))
    into.push_back(value.cast<std::int64_t>());
  else if (py::isinstance<py::float_>(value))
    into.push_back(value.cast<double>());
  else if (py::isinstance<py::str>(value))
    into.push_back(value.cast<std::string>());
  else if (py::isinstance<py::dict>(value))
    into.push_back(table_of(value.cast<py::dict>()));
  else {
    toml::array list;
    for (const py::handle part : value.cast<py::list>())
      put(part, list);
    into.insert(into.end(), std::move(list));
  }
}

std::shared_ptr<const KeyTable> keys_of(const py::dict& document) {
  return std::make_shared<const KeyTable>(KeyTable{table_of(document)});
}

SceneHandle build_keys(const std::string& name, const py::dict& document, const std::string& folder) {
  return handle_of(made_in_thread(
      [=, keys = keys_of(document)] { return SceneBuilder(name).keys(keys, folder).build_with_measures(); }));
}

/// @param array of three axes i, j, k, in this machine's byte order, its strides whole elements
SceneHandle build(const std::string& name, const py::array& array,
                  const std::array<std::array<double, 4>, 4>& affine, bool is_ras, const py::dict& document,
                  const std::string& folder) {
  AddLabels add_labels;
  for (const auto of_type : {labels_of<std::uint8_t>, labels_of<std::uint16_t>, labels_of<std::int16_t>,
                             labels_of<std::int32_t>, labels_of<std::int64_t>})
    if (!add_labels && array.ndim() == 3)
      add_labels = of_type(array, affine);
  if (!add_labels)
    throw py::type_error("expected labels in three axes of uint8, uint16, int16, int32 or int64");
  for (const auto& row : affine)
    for (const double value : row)
      require_finite("affine", value);
  return handle_of(made_in_thread(
      [=, keys = keys_of(document)] {
        SceneBuilder builder(name);
        add_labels(builder);
        if (is_ras)
          builder.world(WorldAxes::ras);
        builder.keys(keys, folder);
        return builder.build_with_measures();
      },
      array));
}

/// Rows of the matrix from indices (i, j, k, 1) to the world [m]. @param first where (0, 0, 0) is
std::array<std::array<double, 4>, 4> affine_rows(const Vec3& first, const std::array<Vec3, 3>& direction,
                                                 const Vec3& spacing) {
  std::array<std::array<double, 4>, 4> rows{};
  rows[3][3] = 1;
  for (std::size_t r = 0; r < 3; ++r) {
    rows[r][3] = first[r];
    for (std::size_t a = 0; a < 3; ++a)
      rows[r][a] = direction[r][a] * spacing[a];
  }
  return rows;
}

py::dict checked(const Scene& scene) {
  const Plausibility found = plausibility(scene);
  py::dict out;
  out["size"] = found.size;
  out["largest_move"] = found.largest_move;
  out["move_over_length"] = found.move_over_length;
  out["mean_strain"] = found.mean_strain;
  out["strain_of_loads"] = found.strain_of_loads;
  out["warnings"] = found.warnings;
  out["cells"] = scene.specimen.n_matter_cells();
  out["nodes"] = scene.specimen.n_matter_nodes();
  std::vector<std::string> left_out;
  for (const LeftOutPiece& piece : scene.left_out)
    if (piece.cells > 0)
      left_out.push_back(piece.name);
  out["left_out"] = left_out;
  return out;
}

using Solve = std::function<Answer(const Scene&, const Control&)>;

std::shared_ptr<const SceneAndMeasures> with_tolerance(std::shared_ptr<const SceneAndMeasures> asked,
                                                       std::optional<double> tolerance) {
  if (!tolerance || *tolerance == asked->scene.relaxation.tolerance)
    return asked;
  if (const auto wanted = wanted_in_range("relaxation", "tolerance", *tolerance))
    throw py::value_error("expected a tolerance, " + *wanted);
  auto changed = std::make_shared<SceneAndMeasures>(*asked);
  changed->scene.relaxation.tolerance = *tolerance;
  return changed;
}

void require_method(const std::string& method) {
  if (std::ranges::find(deform::methods(), method) == deform::methods().end())
    throw py::value_error("expected a method of this module, found \"" + method + "\"");
}

/// @param prepared  makes the scene that is solved; without the interpreter's lock, as `solve`
AnswerHandle solved(const std::function<std::shared_ptr<const SceneAndMeasures>()>& prepared,
                    const Solve& solve, Steering& steering) {
  AnswerHandle made;
  {
    const py::gil_scoped_release unlocked;
    made.asked = prepared();
    made.answer = solve(made.scene(), steering.control());
    fail_where_inside_out(made.scene(), made.answer);
  }
  steering.finish();
  return made;
}

AnswerHandle run(const SceneHandle& handle, const std::string& method, std::optional<double> tolerance,
                 int threads, std::optional<double> seconds, std::optional<std::int64_t> bytes,
                 py::object progress) {
  require_method(method);
  Steering steering(threads, seconds, bytes, std::move(progress));
  return solved(
      [&] { return with_tolerance(handle.asked, tolerance); },
      [&](const Scene& scene, const Control& control) { return deform::solve(scene, method, control); },
      steering);
}

/// A scene step by step: a quasi-static answer to a fraction of moves and loads, as `run --steps`.
/// The body of `coupled` stays from step to step, and limits that the scene asks for are those of the whole.
class StepsHandle {
public:
  StepsHandle(const SceneHandle& handle, std::string method, std::optional<double> tolerance)
      : whole_(with_tolerance(handle.asked, tolerance)), method_(std::move(method)) {
    require_method(method_);
    const Scene& scene = whole_->scene;
    if (!deform::feels_limits(scene, method_))
      return;
    auto known = std::make_shared<SceneAndMeasures>(*whole_);
    known->scene.limits.taut_scale = with_limits(scene).limits.taut_scale;
    whole_ = std::move(known);
  }

  AnswerHandle run(double fraction, int threads, std::optional<double> seconds,
                   std::optional<std::int64_t> bytes, py::object progress) {
    const SoleUse use(is_used_, "series");
    Steering steering(threads, seconds, bytes, std::move(progress));
    return solved(
        [&] {
          return std::make_shared<const SceneAndMeasures>(
              SceneAndMeasures{scaled(whole_->scene, fraction), whole_->measures});
        },
        [&](const Scene& scene, const Control& control) {
          return method_ == "coupled" ? body_.answer(scene, control) : deform::solve(scene, method_, control);
        },
        steering);
  }

private:
  std::shared_ptr<const SceneAndMeasures> whole_;
  std::string method_;
  deform::ElasticBody body_;
  std::atomic<bool> is_used_{false};
};

/// A body that is dragged interactively, with its limits.
class DragHandle {
public:
  DragHandle(const SceneHandle& handle, int threads)
      : asked_(handle.asked), scene_(with_limits(handle.scene())), limits_(scene_),
        drag_(scene_, limits_, std::max(1, threads)) {}

  py::dict move(const Nodes& nodes, const Vec3& by) {
    const SoleUse use(is_used_, "Drag");
    require_finite("by", by);
    check(nodes);
    moves_.clear();
    for (py::ssize_t i = 0; i < nodes.size(); ++i)
      moves_.push_back({nodes.data()[i], by});
    deform::Drag::Step step;
    {
      const py::gil_scoped_release unlocked;
      step = moves_.size() == 1 ? drag_.move_to(moves_[0].node, by) : drag_.move_to(moves_);
    }
    py::dict out;
    out["is_cut"] = step.is_cut;
    out["visited"] = step.visited;
    return out;
  }
  void release(const Nodes& nodes) {
    const SoleUse use(is_used_, "Drag");
    check(nodes);
    for (py::ssize_t i = 0; i < nodes.size(); ++i)
      drag_.release(nodes.data()[i]);
  }
  /// A new array: the body goes on moving.
  py::array displacement() const {
    const SoleUse use(is_used_, "Drag");
    auto* const state = new Displacement(drag_.displacement());
    const py::capsule owner(state, [](void* kept) { delete static_cast<Displacement*>(kept); });
    return displacement_view(owner, scene_.specimen.grid, *state);
  }
  double residue() const {
    const SoleUse use(is_used_, "Drag");
    return drag_.residue().largest;
  }

private:
  void check(const Nodes& nodes) const {
    const Grid& grid = scene_.specimen.grid;
    if (nodes.size() == 0)
      throw py::value_error("expected at least one node");
    for (py::ssize_t i = 0; i < nodes.size(); ++i)
      if (const std::int64_t node = nodes.data()[i];
          node < 0 || node >= grid.n_nodes() || !scene_.specimen.is_node(grid.node_at(node)))
        throw py::value_error("expected nodes of the body, found " + std::to_string(node));
  }

  std::shared_ptr<const SceneAndMeasures> asked_;
  Scene scene_;
  LinkLimits limits_;
  deform::Drag drag_;
  std::vector<deform::Drag::Move> moves_;
  mutable std::atomic<bool> is_used_{false};
};

} // namespace

void bind_scenes(py::module_& module) {
  module.def("methods",
             [] { return std::vector<std::string>(deform::methods().begin(), deform::methods().end()); });
  module.def("read_scene", [](const std::string& file) {
    return handle_of(made_in_thread([=] { return read_scene_and_measures(file); }));
  });
  module.def("parse_scene", [](const std::string& text, const std::string& file) {
    return handle_of(made_in_thread([=] { return parse_scene_and_measures(text, file); }));
  });
  module.def("build_keys", &build_keys);
  module.def("build_scene", &build);
  module.def("image_grid", [](const std::string& file) {
    const ImageInfo info = read_image_info(file);
    return py::make_tuple(info.size, affine_rows(info.origin, info.direction, info.spacing),
                          info.world == WorldAxes::lps ? "lps" : "ras");
  });
  module.def("read_voxels", [](const std::string& file) {
    const Image image = made_in_thread([=] { return read_image(file); });
    py::array_t<float> voxels({image.info.size[2], image.info.size[1], image.info.size[0]});
    if (image.info.components != 1)
      throw py::value_error("expected an image of one value a voxel: " + file);
    std::copy(image.values.begin(), image.values.end(), voxels.mutable_data());
    return voxels;
  });
  module.def("write_labels", [](const Labels& labels, const std::array<std::array<double, 4>, 4>& affine,
                                const std::string& file) {
    // The builder's rules for affines are those of images; a body of everything shows what it made of them.
    Image image;
    for (std::size_t a = 0; a < 3; ++a) {
      image.info.size[a] = static_cast<int>(labels.shape(static_cast<py::ssize_t>(2 - a)));
      image.info.spacing[a] = std::hypot(affine[0][a], affine[1][a], affine[2][a]);
      image.info.origin[a] = affine[a][3];
      for (std::size_t r = 0; r < 3; ++r)
        image.info.direction[r][a] = affine[r][a] / image.info.spacing[a];
    }
    image.info.world = WorldAxes::ras;
    image.values.assign(labels.data(), labels.data() + labels.size());
    const py::gil_scoped_release unlocked;
    write_image(image, file, {StoredAs::labels, {}});
  });
  py::class_<SceneHandle>(module, "Scene")
      .def_property_readonly("name", [](const SceneHandle& s) { return s.scene().name; })
      .def_property_readonly("title", [](const SceneHandle& s) { return s.scene().title; })
      .def_property_readonly("dimension", [](const SceneHandle& s) { return s.scene().dimension(); })
      .def_property_readonly("cells", [](const SceneHandle& s) { return s.scene().specimen.grid.cells(); })
      .def_property_readonly("nodes", [](const SceneHandle& s) { return s.scene().specimen.grid.nodes(); })
      .def_property_readonly("spacing",
                             [](const SceneHandle& s) { return s.scene().specimen.grid.spacing(); })
      .def_property_readonly("image", [](const SceneHandle& s) { return s.scene().specimen.image; })
      .def_property_readonly("world",
                             [](const SceneHandle& s) {
                               const WorldAxes world = s.scene().specimen.placement.world;
                               return world == WorldAxes::ras ? "ras" : world == WorldAxes::lps ? "lps" : "";
                             })
      .def_property_readonly("node_affine",
                             [](const SceneHandle& s) {
                               const Specimen& body = s.scene().specimen;
                               return affine_rows(point_in_world(body.placement, body.origin),
                                                  body.placement.direction, body.grid.spacing());
                             })
      .def_property_readonly("direction",
                             [](const SceneHandle& s) { return s.scene().specimen.placement.direction; })
      .def_property_readonly(
          "fibres",
          [](const SceneHandle& s) -> py::object {
            if (!s.scene().has_fibres())
              return py::none();
            const Specimen& body = s.scene().specimen;
            auto shape = shape_of(body.grid, body.grid.cells());
            shape.push_back(3);
            py::array_t<double> fibres(shape);
            double* to = fibres.mutable_data();
            for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
              to = std::ranges::copy(body.is_matter(cell) ? body.fibre_of(cell) : Vec3{}, to).out;
            return fibres;
          })
      .def_property_readonly("materials",
                             [](const SceneHandle& s) {
                               std::vector<std::string> names;
                               for (const Material& material : s.scene().materials)
                                 names.push_back(material.name);
                               return names;
                             })
      .def_property_readonly("material_id",
                             [](const py::object& self) -> py::array {
                               const Specimen& body = self.cast<const SceneHandle&>().scene().specimen;
                               const auto shape = shape_of(body.grid, body.grid.cells());
                               if (body.material_id.empty()) {
                                 py::array_t<std::uint8_t> zeros(shape);
                                 std::fill_n(zeros.mutable_data(), zeros.size(), std::uint8_t{0});
                                 return zeros;
                               }
                               std::vector<py::ssize_t> strides;
                               for (int axis = body.grid.dimension(); axis-- > 0;)
                                 strides.push_back(axis == 0   ? 1
                                                   : axis == 1 ? body.grid.cells()[0]
                                                               : py::ssize_t{body.grid.cells()[0]} *
                                                                     body.grid.cells()[1]);
                               return view_of(self, body.material_id.data(), shape, strides);
                             })
      .def_property_readonly("labels",
                             [](const SceneHandle& s) -> py::object {
                               const Specimen& body = s.scene().specimen;
                               if (body.label.empty())
                                 return py::none();
                               py::array_t<std::int32_t> labels(shape_of(body.grid, body.grid.cells()));
                               std::copy(body.label.begin(), body.label.end(), labels.mutable_data());
                               return labels;
                             })
      .def("check", [](const SceneHandle& s) { return checked(s.scene()); })
      .def("scaled",
           [](const SceneHandle& s, double fraction) -> SceneHandle {
             return {std::make_shared<const SceneAndMeasures>(
                 SceneAndMeasures{scaled(s.scene(), fraction), s.asked->measures})};
           })
      .def("nodes_in",
           [](const SceneHandle& s, const std::string& where) {
             const auto nodes = nodes_in(s.scene(), where);
             return py::array_t<std::int64_t>(static_cast<py::ssize_t>(nodes.size()), nodes.data());
           })
      .def("nodes_in",
           [](const SceneHandle& s, const py::dict& where) {
             const auto nodes = nodes_in(s.scene(), *keys_of(where));
             return py::array_t<std::int64_t>(static_cast<py::ssize_t>(nodes.size()), nodes.data());
           })
      .def("run", &run);
  py::class_<StepsHandle>(module, "Steps")
      .def(py::init<const SceneHandle&, std::string, std::optional<double>>())
      .def("run", &StepsHandle::run);
  py::class_<DragHandle>(module, "Drag")
      .def(py::init<const SceneHandle&, int>())
      .def("move", &DragHandle::move)
      .def("release", &DragHandle::release)
      .def_property_readonly("displacement", &DragHandle::displacement)
      .def_property_readonly("residue", &DragHandle::residue);
}

} // namespace maille::python
