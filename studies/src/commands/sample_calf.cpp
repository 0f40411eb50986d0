/// The calf of `maille new calf`: closed formulas, so that all users have the same one.
///
/// A right lower leg, 240 mm from ankle to knee, in RAS millimetres with the ankle at the origin. Each part
/// is an ellipse across the leg, whose centre and half axes depend on the height; a part has a lower and an
/// upper end, and the later part of the list wins in overlaps. The scan has the grey values of a T1-weighted
/// MRI with noise of a fixed sequence. Sizes are those of a slender adult, rounded; this is a drawing of a
/// calf, not an atlas.

#include "cli/commands.hpp"
#include "cli/help.hpp"
#include "export/whole_file.hpp"
#include "maille/images/write_image.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <random>

namespace maille::studies {
namespace {

namespace fs = std::filesystem;

constexpr double length = 240; ///< [mm]
constexpr Index3 voxels{56, 56, 60};
constexpr Vec3 spacing{2, 2, 4}; ///< [mm]

/// In mm; x points to the right, which is lateral here, y to anterior.
struct Part {
  const char* name;
  float label, grey;
  double from, to;             ///< lower and upper end, relative to the length
  double x, y, half_x, half_y; ///< at mid-height
  double taper;                ///< exponent of its half axes over the height: 0 is a cylinder
};

constexpr std::array<Part, 10> parts{{
    {"fat", 1, 900, -1, 2, 1, -6, 49, 46, 0},
    {"deep muscles", 2, 330, -1, 2, 1, -5, 44, 41, 0},
    {"soleus", 3, 300, 0.08, 0.86, 2, -19, 25, 15, 0.6},
    {"gastrocnemius medialis", 4, 305, 0.34, 1.02, -17, -31, 17, 10, 0.6},
    {"gastrocnemius lateralis", 5, 305, 0.40, 1.02, 17, -30, 15, 9, 0.6},
    {"tibialis anterior", 6, 310, 0.10, 0.96, 12, 20, 12, 10, 0.6},
    {"Achilles tendon", 7, 120, -1, 0.36, 1, -36, 7, 4, 0},
    {"tibia", 8, 60, -1, 2, -10, 13, 12, 13, 0},
    {"fibula", 9, 60, -1, 2, 23, -1, 6, 6, 0},
    {"marrow", 10, 850, -1, 2, -10, 13, 7, 8, 0},
}};

/// The leg is thin at the ankle and thickest at two thirds of its height.
double girth(double height) {
  return 0.62 + 0.38 * std::exp(-std::pow((height - 0.68) / 0.36, 2));
}

/// Squared relative distance from its centre, 1 at its border; infinite above and below the part.
double place_in(const Part& part, double x, double y, double height) {
  if (height < part.from || height > part.to)
    return INFINITY;
  const double along = std::clamp((height - part.from) / (part.to - part.from), 0.0, 1.0);
  const double size = girth(height) * std::pow(4 * along * (1 - along), part.taper);
  const double dx = x - part.x * girth(height), dy = y - part.y * girth(height);
  return std::pow(dx / (part.half_x * size), 2) + std::pow(dy / (part.half_y * size), 2);
}

/// Stored like scanner images, the first axis to the left and the second to posterior.
Image empty_image() {
  Image image;
  image.info.size = voxels;
  image.info.world = WorldAxes::ras;
  image.info.direction = {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
  for (int a = 0; a < 3; ++a)
    image.info.spacing[a] = 1e-3 * spacing[a];
  image.info.origin = {0.056, 0.050, 0.002};
  image.values.assign(image.info.n_voxels(), 0);
  return image;
}

std::array<Image, 2> drawn() {
  std::array<Image, 2> both{empty_image(), empty_image()};
  std::mt19937 random(1995);
  std::size_t voxel = 0;
  for (int k = 0; k < voxels[2]; ++k)
    for (int j = 0; j < voxels[1]; ++j)
      for (int i = 0; i < voxels[0]; ++i, ++voxel) {
        const Vec3& origin = both[0].info.origin;
        const double x = 1e3 * origin[0] - i * spacing[0], y = 1e3 * origin[1] - j * spacing[1],
                     height = (1e3 * origin[2] + k * spacing[2]) / length;
        both[1].values[voxel] = 10;
        for (const Part& part : parts)
          if (const double place = place_in(part, x, y, height); place <= 1) {
            const bool is_fascia = part.taper > 0 && place > 0.8; // fascia of a muscle: brighter
            both[0].values[voxel] = part.label;
            both[1].values[voxel] = part.grey + (is_fascia ? 150.0F : 0);
          }
        double noise = 0; // sum of four uniform ones: nearly normal, deviation 23
        for (int n = 0; n < 4; ++n)
          noise += 40.0 * (double(random()) / double(std::mt19937::max()) - 0.5);
        both[1].values[voxel] = static_cast<float>(std::round(std::abs(both[1].values[voxel] + noise)));
      }
  return both;
}

std::vector<std::pair<std::string, std::string>> segments() {
  std::vector<std::pair<std::string, std::string>> keys;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    keys.emplace_back(fmt::format("Segment{}_ID", p), fmt::format("Segment_{}", p + 1));
    keys.emplace_back(fmt::format("Segment{}_Name", p), parts[p].name);
    keys.emplace_back(fmt::format("Segment{}_LabelValue", p), fmt::format("{:g}", parts[p].label));
    keys.emplace_back(fmt::format("Segment{}_Layer", p), "0");
  }
  return keys;
}

} // namespace

void new_calf(const fs::path& folder) {
  const std::array<std::string, 5> names{"labels.nii.gz", "labels.seg.nrrd", "scan.nii.gz", "landmarks.fcsv",
                                         "calf.toml"};
  prepare_folder(folder);
  for (const std::string& name : names) {
    if (!may_overwrite() && fs::exists(folder / name))
      throw UsageError(fmt::format("{}: expected no such file, found one; --overwrite replaces it",
                                   (folder / name).string()));
    prepare_file("--out", (folder / name).string());
  }
  const auto images = drawn();
  const auto write_to = [&](const std::string& name, const Image& image, const ImageFileOptions& options) {
    write_whole(folder / name, [&](const fs::path& file) { write_image(image, file, options); });
    fmt::print("wrote {}\n", (folder / name).string());
  };
  write_to(names[0], images[0], {StoredAs::labels, {}});
  write_to(names[1], images[0], {StoredAs::labels, segments()});
  write_to(names[2], images[1], {StoredAs::labels, {}});
  write_whole(folder / names[3], landmarks_fcsv());
  write_whole(folder / names[4], calf_toml());
  fmt::print("wrote {0}/{1}\nwrote {0}/{2}\n", folder.string(), names[3], names[4]);
}

} // namespace maille::studies
