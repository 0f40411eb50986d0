// Images that go along with an answer, and the fields that other programs take.

#include "binding.hpp"
#include "maille/images/write_image.hpp"
#include "maille/scene/warp/warp.hpp"

#include <cmath>

namespace maille::python {

namespace {

using Values = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Rows = std::array<std::array<double, 4>, 4>;

/// A grid of voxels by its affine [m], of which the columns are perpendicular.
ImageInfo grid_of(const Index3& size, const Rows& affine, const std::string& world) {
  ImageInfo info;
  info.size = size;
  for (std::size_t a = 0; a < 3; ++a) {
    info.spacing[a] = std::hypot(affine[0][a], affine[1][a], affine[2][a]);
    info.origin[a] = affine[a][3];
    for (std::size_t r = 0; r < 3; ++r)
      info.direction[r][a] = affine[r][a] / info.spacing[a];
  }
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      double cosine = 0;
      for (std::size_t r = 0; r < 3; ++r)
        cosine += info.direction[r][a] * info.direction[r][b];
      if (!(std::abs(cosine - (a == b ? 1 : 0)) <= 1e-3))
        throw py::value_error("expected an affine whose columns are perpendicular and not zero");
    }
  info.world = world == "lps" ? WorldAxes::lps : WorldAxes::ras;
  return info;
}

std::vector<DeformedBody> bodies_of(const AnswerHandle& handle) {
  if (!handle.has_displacement() || handle.scene().dimension() != 3)
    throw py::value_error("expected an answer of three dimensions with a displacement");
  return {{&handle.scene().specimen, &handle.answer.displacement}};
}

/// An array of an image's values, (components, k, j, i) or (k, j, i), that keeps their memory.
py::array array_of(Image image) {
  auto* const kept = new Image(std::move(image));
  const py::capsule owner(kept, [](void* memory) { delete static_cast<Image*>(memory); });
  const Index3& n = kept->info.size;
  std::vector<py::ssize_t> shape{n[2], n[1], n[0]};
  if (kept->info.components > 1)
    shape.insert(shape.begin(), kept->info.components);
  return py::array_t<float>(std::move(shape), kept->values.data(), owner);
}

py::dict record_of(const WarpedLabel& label) {
  py::dict record;
  record["label"] = label.label;
  record["voxels"] = label.voxels;
  record["warped_voxels"] = label.warped;
  record["volume_at_rest"] = label.volume_at_rest;
  record["volume"] = label.volume;
  record["sub_voxel_volume"] = label.sub_voxel_volume;
  record["integral_of_det_f"] = label.integral_of_det_f;
  record["centroid_at_rest"] = label.centroid_at_rest;
  record["centroid"] = label.centroid;
  record["folded_cells"] = label.folded;
  record["voxels_left_out"] = label.left_out;
  return record;
}

/// The pull of an answer on one grid; images on it go through it one after the other.
class PullHandle {
  using Bodies = std::vector<DeformedBody>;
  /// make(pull, bodies), in a thread of its own.
  template<class Make>
  auto made(Make make) const {
    return made_in_thread(
        [make = std::move(make), pull = pull_, bodies = bodies_] { return make(*pull, bodies); }, answer_);
  }

public:
  PullHandle(const py::object& answer, const Index3& size, const Rows& affine, const std::string& world)
      : answer_(answer), bodies_(bodies_of(answer.cast<const AnswerHandle&>())),
        pull_(std::make_shared<const Pull>(made_in_thread(
            [grid = grid_of(size, affine, world), bodies = bodies_] { return pull_of(grid, bodies); },
            answer))) {}

  py::array warp(const Values& values, bool are_labels, float background) const {
    require_finite("background", background);
    return array_of(made([are_labels, background, image = image_of(values)](const Pull& pull, const Bodies&) {
      return are_labels ? warped_labels(pull, image, background) : warped(pull, image, background);
    }));
  }
  py::list table(const Values& values) const {
    const auto rows = made([labels = image_of(values)](const Pull& pull, const Bodies& bodies) {
      return warped_label_table(pull, bodies, labels, warped_labels(pull, labels),
                                volume_ratio(pull.grid, bodies));
    });
    py::list list;
    for (const WarpedLabel& row : rows)
      list.append(record_of(row));
    return list;
  }
  py::array jacobian() const {
    return array_of(
        made([](const Pull& pull, const Bodies& bodies) { return volume_ratio(pull.grid, bodies); }));
  }
  void save(const std::string& file, bool forward) const {
    const Image field = made([forward](const Pull& pull, const Bodies& bodies) {
      return forward ? push_field(pull.grid, bodies) : pull_field(pull, bodies);
    });
    const py::gil_scoped_release unlocked;
    ImageFileOptions options;
    if (forward)
      options.nrrd_keys = {{"displacement field type", "modeling"}};
    write_image(field, file, options);
  }
  py::dict counts() const {
    py::dict out;
    out["voxels"] = pull_->reached;
    out["voxels_at_rest"] = pull_->at_rest;
    out["voxels_vacated"] = pull_->vacated;
    out["voxels_reached_twice"] = pull_->reached_twice;
    out["folded_cells"] = pull_->folded_cells;
    return out;
  }

private:
  /// @param values (k, j, i)
  Image image_of(const Values& values) const {
    const ImageInfo& grid = pull_->grid;
    if (values.ndim() != 3 || values.shape(2) != grid.size[0] || values.shape(1) != grid.size[1] ||
        values.shape(0) != grid.size[2])
      throw py::value_error("expected an image on the grid that is warped");
    return {grid, std::vector<float>(values.data(), values.data() + values.size())};
  }

  py::object answer_; ///< an AnswerHandle, which the bodies are of
  Bodies bodies_;
  std::shared_ptr<const Pull> pull_; ///< shared with work that Ctrl-C left behind
};

} // namespace

void bind_warps(py::module_& module) {
  py::class_<PullHandle>(module, "Pull")
      .def(py::init<const py::object&, const Index3&, const Rows&, const std::string&>())
      .def("warp", &PullHandle::warp)
      .def("table", &PullHandle::table)
      .def("jacobian", &PullHandle::jacobian)
      .def("save", &PullHandle::save)
      .def_property_readonly("counts", &PullHandle::counts);
}

} // namespace maille::python
