#include "export/warp_files.hpp"

#include "export/whole_file.hpp"
#include "maille/base/csv.hpp"
#include "maille/images/write_image.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Distance between an image and the body, in words.
std::string apart_in_words(const ImageInfo& image, const Specimen& body) {
  const ImageInfo info = in_world(image, body.placement.world);
  Eigen::AlignedBox3d of_image, of_body;
  const Index3 last{body.grid.cells()};
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x = info.origin;
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t a = 0; a < 3; ++a)
        x[row] += info.direction[row][a] * info.spacing[a] * ((corner >> a & 1 ? info.size[a] : 0) - 0.5);
    of_image.extend(Eigen::Vector3d::Map(x.data()));
    const Vec3 y = point_in_world(
        body.placement,
        body.position({corner & 1 ? last[0] : 0, corner & 2 ? last[1] : 0, corner & 4 ? last[2] : 0}));
    of_body.extend(Eigen::Vector3d::Map(y.data()));
  }
  const double gap = of_image.exteriorDistance(of_body),
               middles = (of_image.center() - of_body.center()).norm();
  return fmt::format("{:.4g} mm from the body to the image, {:.4g} mm from middle to middle", 1e3 * gap,
                     1e3 * middles);
}

/// @throws std::runtime_error if no voxel is in the body
Pull pull_on(const ImageInfo& grid, const fs::path& file, const std::vector<DeformedBody>& bodies) {
  Pull pull = pull_of(grid, bodies);
  if (pull.reached == 0 && pull.at_rest == 0)
    throw std::runtime_error(
        fmt::format("{}: expected an image over the body, found none of its voxels in it, at "
                    "rest or deformed: {}",
                    file.string(), apart_in_words(grid, *bodies.front().specimen)));
  return pull;
}

/// A body without a stated world is in the world of the image.
bool is_same_grid(const ImageInfo& a, const ImageInfo& b) {
  const auto is_near = [](double x, double y, double of) { return std::abs(x - y) <= 1e-4 * of; };
  if (a.size != b.size || a.world != b.world)
    return false;
  for (std::size_t r = 0; r < 3; ++r) {
    if (!is_near(a.spacing[r], b.spacing[r], a.spacing[r]) ||
        !is_near(a.origin[r], b.origin[r], a.spacing[r]))
      return false;
    for (std::size_t c = 0; c < 3; ++c)
      if (!is_near(a.direction[r][c], b.direction[r][c], 1))
        return false;
  }
  return true;
}

std::optional<fs::path> labels_of(const Scene& scene, const WarpRequest& request) {
  if (request.labels)
    return request.labels;
  if (!scene.specimen.image.empty() && !scene.specimen.label.empty())
    return fs::path(scene.specimen.image);
  return std::nullopt;
}

class Writing {
public:
  Writing(const fs::path& stem, std::vector<fs::path>& files) : stem_(stem), files_(files) {}
  void image(const Image& image, const std::string& name, const ImageFileOptions& options = {}) {
    const fs::path file = path(name);
    write_whole(file, [&](const fs::path& unfinished) { write_image(image, unfinished, options); });
    files_.push_back(file);
  }
  void surfaces(const std::vector<BodySurface>& surfaces, const std::string& name, LengthUnit unit) {
    const fs::path file = path(name);
    write_whole(file, [&](const fs::path& unfinished) { write_surfaces(surfaces, unfinished, unit); });
    files_.push_back(file);
  }
  void text(const std::string& text, const std::string& name) {
    write_whole(path(name), text);
    files_.push_back(path(name));
  }

private:
  fs::path path(const std::string& name) const {
    fs::path file = stem_;
    file += name;
    return file;
  }
  fs::path stem_;
  std::vector<fs::path>& files_;
};

std::string csv_of(const std::vector<WarpedLabel>& labels) {
  constexpr double millimetres = 1e3;
  std::string text =
      "label,voxels,warped_voxels,volume_at_rest_ml,volume_ml,integral_of_det_f_ml,centroid_at_rest_x_mm,"
      "centroid_at_rest_y_mm,centroid_at_rest_z_mm,centroid_x_mm,centroid_y_mm,centroid_z_mm,"
      "folded_cells,voxels_left_out,sub_voxel_volume_ml\n";
  for (const WarpedLabel& row : labels) {
    text += fmt::format("{},{},{},{:.9g},{:.9g},{:.9g}", row.label, row.voxels, row.warped,
                        1e6 * row.volume_at_rest, 1e6 * row.volume, 1e6 * row.integral_of_det_f);
    for (const Vec3& at : {row.centroid_at_rest, row.centroid})
      for (const double x : at)
        text += fmt::format(",{:.9g}", millimetres * x);
    text += fmt::format(",{},{},{:.9g}\n", row.folded, row.left_out, 1e6 * row.sub_voxel_volume);
  }
  return text;
}

void add_warnings(WarpedFiles& made) {
  made.warnings = file_warnings(true);
  if (made.folded_cells > 0)
    made.warnings.push_back(
        fmt::format("{} cells are folded: where they are, images mean nothing", made.folded_cells));
  if (made.reached_twice > 0)
    made.warnings.push_back(
        fmt::format("{} voxels are covered by two cells or more: the first has them", made.reached_twice));
  // From a thousand voxels on, sub-voxel sums give volumes to half a percent.
  constexpr std::int64_t countable = 1000;
  constexpr double told_apart = 0.01;
  for (const WarpedLabel& label : made.labels)
    if (const double lost = 1 - label.sub_voxel_volume / label.integral_of_det_f;
        label.voxels >= countable && label.folded == 0 && lost > told_apart)
      made.warnings.push_back(
          fmt::format("{:.2g} % of label {}'s volume is not in the warped image: it has left the image, or "
                      "other matter has its place",
                      100 * lost, label.label));
  std::int64_t left_out = 0;
  for (const WarpedLabel& label : made.labels)
    left_out += label.left_out;
  if (left_out > 0)
    made.warnings.push_back(fmt::format(
        "{} voxels with labels are no part of the body: background in the warped labels", left_out));
}

} // namespace

std::string why_no_warp(const Scene& scene, const WarpRequest& request) {
  if (scene.dimension() != 3)
    return fmt::format("a three-dimensional body, found one of {}", scene.dimension());
  if (!request.image && !labels_of(scene, request))
    return "--image or --labels, as the scene's body is from no segmentation, found neither";
  return "";
}

WarpedFiles write_warp(const Scene& scene, const Answer& answer, const WarpRequest& request,
                       const fs::path& stem) {
  WarpedFiles made;
  Writing writing(stem, made.files);
  const std::vector<DeformedBody> bodies{{&scene.specimen, &answer.displacement}};
  std::vector<std::string> endings{"nii.gz"};
  endings.insert(endings.end(), request.also.begin(), request.also.end());
  const auto in_all_formats = [&](const Image& image, const std::string& name, StoredAs stored_as) {
    for (const std::string& ending : endings)
      writing.image(image, name + "." + ending, {stored_as, {}});
  };
  std::optional<Pull> pull;
  if (request.image) {
    const Image image = read_image(*request.image);
    pull = pull_on(image.info, *request.image, bodies);
    in_all_formats(warped(*pull, image, request.background), "warped", stored_form(*request.image));
    if (image.info.components > 1)
      warn_of_file(*request.image,
                   fmt::format("each of {} values a voxel is carried by itself: vectors and tensors "
                               "do not turn with the tissue",
                               image.info.components));
  }
  const ImageInfo of_image = pull ? pull->grid : ImageInfo{};
  if (const auto file = labels_of(scene, request)) {
    Image labels = read_image(*file);
    if (const std::int64_t n = round_labels(labels.values); n > 0)
      warn_of_file(*file,
                   fmt::format("{} voxels are whole numbers but for rounding: they count as these", n));
    std::optional<Pull> of_labels;
    if (!pull)
      pull = pull_on(labels.info, *file, bodies);
    else if (ImageInfo info = labels.info; info.components = 1, !is_same_grid(info, of_image))
      of_labels = pull_on(labels.info, *file, bodies);
    const Pull& used = of_labels ? *of_labels : *pull;
    const Image after = warped_labels(used, labels);
    in_all_formats(after, "labels_warped", StoredAs::labels);
    const Image ratio = volume_ratio(used.grid, bodies);
    made.labels = warped_label_table(used, bodies, labels, after, ratio);
    writing.text(csv_of(made.labels), "labels.csv");
  }
  made.reached = pull->reached;
  made.at_rest = pull->at_rest;
  made.vacated = pull->vacated;
  made.reached_twice = pull->reached_twice;
  made.folded_cells = pull->folded_cells;
  const ImageInfo grid = pull->grid;
  {
    const Image field = pull_field(*pull, bodies);
    pull.reset();
    in_all_formats(field, "pull", StoredAs::float32);
  }
  writing.image(push_field(grid, bodies), "push.nrrd",
                {StoredAs::float32, {{"displacement field type", "modeling"}}});
  writing.image(volume_ratio(grid, bodies), "jacobian.nii.gz");
  if (!request.surfaces.empty()) {
    const auto surfaces = surfaces_of(bodies.front(), scene.materials);
    for (const std::string& ending : request.surfaces)
      if (ending == "stl") // which knows no parts
        for (const BodySurface& surface : surfaces)
          writing.surfaces({surface}, fmt::format("surface_{}.stl", surface.part), request.unit);
      else
        writing.surfaces(surfaces, "surface." + ending, request.unit);
  }
  add_warnings(made);
  return made;
}

} // namespace maille::studies
