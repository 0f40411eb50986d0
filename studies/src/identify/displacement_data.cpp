// Measured displacements, of points or of an image, as measures of a scene and what was seen of them.
#include "identify/identify.hpp"

#include "maille/scene/warp/displacement_field.hpp"

#include <fmt/format.h>

#include <array>

namespace maille::studies {

namespace {

constexpr std::array<const char*, 3> ends{"_x", "_y", "_z"};

Measure displacement_at(const std::string& name, MaterialPoint point) {
  Measure measure;
  measure.name = name;
  measure.kind = MeasureKind::displacement;
  measure.figure = MeasureFigure::vector;
  measure.points = {std::move(point)};
  measure.where = "a point";
  return measure;
}

void add(const std::string& name, MaterialPoint point, const Vec3& displacement, double sigma, int line,
         int dimension, DisplacementData& data) {
  data.measures.push_back(displacement_at(name, std::move(point)));
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a)
    data.observations.push_back({name + ends[a], displacement[a], sigma, line});
}

/// Where points of an image's or a table's world are at rest in the body.
MaterialPoint in_body(const Specimen& body, const Vec3& world) {
  return located(body, point_in_object(body.placement, world));
}

void read_image(const std::filesystem::path& file, double sigma, const Scene& scene, DisplacementData& data) {
  const DisplacementImage image(file, 1e-3, &scene.specimen);
  const ImageInfo& info = image.info();
  const bool is_of_other_world = read_image_info(file).direction[0] != info.direction[0];
  std::int64_t not_finite = 0;
  for (std::int64_t voxel = 0; voxel < info.n_voxels(); ++voxel) {
    const std::int64_t row = voxel / info.size[0];
    const Index3 at{static_cast<int>(voxel % info.size[0]), static_cast<int>(row % info.size[1]),
                    static_cast<int>(row / info.size[1])};
    Vec3 world = info.origin;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t a = 0; a < 3; ++a)
        world[r] += info.direction[r][a] * info.spacing[a] * at[a];
    MaterialPoint point = in_body(scene.specimen, world);
    if (point.cells.empty())
      continue;
    auto u = image.at(world);
    if (u && image.is_along_object())
      u = to_world(scene.specimen.placement, *u);
    else if (u && is_of_other_world)
      u = {-(*u)[0], -(*u)[1], (*u)[2]};
    if (!u)
      ++not_finite;
    else
      add(fmt::format("voxel_{}_{}_{}", at[0], at[1], at[2]), std::move(point), *u, sigma, 0,
          scene.dimension(), data);
  }
  if (not_finite > 0)
    throw InputError({{file.string(), 0, "", "a number in every voxel of the body",
                       fmt::format("none in {} of them", not_finite)}});
}

void read_points(const std::filesystem::path& file, std::optional<double> sigma, const Scene& scene,
                 DisplacementData& data) {
  std::vector<Fault> faults;
  for (const DisplacementPoint& seen : read_displacement_points(file)) {
    MaterialPoint point = in_body(scene.specimen, seen.place);
    if (point.cells.empty())
      faults.push_back({file.string(), seen.line, "x", "a point of the body at rest, in its world",
                        fmt::format("({:.6g}, {:.6g}, {:.6g}) m, where there is no matter", seen.place[0],
                                    seen.place[1], seen.place[2])});
    const auto of_point = seen.sigma ? seen.sigma : sigma;
    if (!of_point)
      faults.push_back({file.string(), seen.line, "sigma", "a column `sigma`, or --sigma", "neither"});
    else if (!point.cells.empty())
      add(fmt::format("point_{}", seen.line), std::move(point), seen.displacement, *of_point, seen.line,
          scene.dimension(), data);
  }
  if (!faults.empty())
    throw InputError(std::move(faults));
}

} // namespace

bool is_table_of_points(std::string_view text) {
  const std::string_view first = text.substr(0, text.find('\n'));
  return first.find("ux") != std::string_view::npos && first.find("measure") == std::string_view::npos;
}

DisplacementData read_displacement_data(const std::filesystem::path& file, std::optional<double> sigma,
                                        const Scene& scene) {
  DisplacementData data;
  if (!is_image_file(file))
    read_points(file, sigma, scene, data);
  else if (!sigma)
    throw InputError(
        {{file.string(), 0, "", "--sigma: how exact the image's displacements are, e.g. \"0.1 mm\"",
          "an image alone"}});
  else
    read_image(file, *sigma, scene, data);
  if (data.observations.empty())
    throw InputError({{file.string(), 0, "", "displacements of the body at rest, in its world",
                       "none of them where there is matter"}});
  return data;
}

} // namespace maille::studies
