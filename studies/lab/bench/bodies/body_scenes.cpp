#include "bench/bodies/body_scenes.hpp"

#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene_builder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

namespace maille::lab {

namespace {

namespace fs = std::filesystem;

constexpr double cell = 1e-3; // m
constexpr double solid_share = 0.3;

Material isotropic(const char* name, double youngs_modulus, double poisson_ratio) {
  Material material;
  material.name = name;
  material.elasticity = ElasticConstants::isotropic(youngs_modulus, poisson_ratio);
  return material;
}

/// Sets to 0 what is 1 and not of the largest piece of ones that hang together by faces.
void keep_largest_piece(std::vector<std::uint8_t>& labels, int n) {
  std::vector<std::int32_t> piece(labels.size(), -1);
  std::vector<std::size_t> open;
  std::int32_t n_pieces = 0, largest = -1;
  std::size_t most = 0;
  const auto along = [n](std::size_t axis) {
    return axis == 0   ? std::size_t{1}
           : axis == 1 ? static_cast<std::size_t>(n)
                       : static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  };
  for (std::size_t seed = 0; seed < labels.size(); ++seed) {
    if (labels[seed] != 1 || piece[seed] >= 0)
      continue;
    std::size_t size = 0;
    piece[seed] = n_pieces;
    open.push_back(seed);
    while (!open.empty()) {
      const std::size_t at = open.back();
      open.pop_back();
      ++size;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t place = at / along(axis) % static_cast<std::size_t>(n);
        for (const bool is_upper : {false, true}) {
          if (place == (is_upper ? static_cast<std::size_t>(n) - 1 : 0))
            continue;
          const std::size_t other = is_upper ? at + along(axis) : at - along(axis);
          if (labels[other] == 1 && piece[other] < 0) {
            piece[other] = n_pieces;
            open.push_back(other);
          }
        }
      }
    }
    if (size > most) {
      most = size;
      largest = n_pieces;
    }
    ++n_pieces;
  }
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (piece[i] != largest)
      labels[i] = 0;
}

std::vector<float> gyroid(int n, int period) {
  std::vector<float> sine, cosine, values;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / period;
    sine.push_back(static_cast<float>(std::sin(angle)));
    cosine.push_back(static_cast<float>(std::cos(angle)));
  }
  for (std::size_t z = 0; z < sine.size(); ++z)
    for (std::size_t y = 0; y < sine.size(); ++y)
      for (std::size_t x = 0; x < sine.size(); ++x)
        values.push_back(sine[x] * cosine[y] + sine[y] * cosine[z] + sine[z] * cosine[x]);
  return values;
}

Scene elastic(Scene scene) {
  scene.limits = {};
  return scene;
}

Scene of_repository(const char* file) {
  return elastic(read_scene(fs::path(MAILLE_SCENES) / file));
}

/// Bone of the head by a threshold, pressed together by 1 %.
Scene bone_of_head() {
  return parse_scene(
      "[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/head_ct/headsq.mha\"\nthreshold = "
      "1150\nmaterial = { youngs_modulus = \"15 GPa\", poisson_ratio = 0.3, name = \"bone\" }\n"
      "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = \"z+\"\nby = [0, 0, \"-1.4 mm\"]\n",
      "bone_of_head.toml");
}

void add_images(std::vector<Body>& all, BenchReport& report) {
  if (has_data("calf_mri/labels.nii.gz")) {
    all.push_back({"soleus", of_repository("calf_soleus.toml"), true});
    if (has_data("calf_mri/DTI-tensor.nii.gz"))
      all.push_back({"soleus, DTI", of_repository("calf_soleus_dti.toml"), true});
    all.push_back({"both legs", of_repository("calf_both_legs.toml"), true});
  } else
    report.notes.emplace_back("muscles of a calf omitted, and the checks of both legs: MAILLE_DATA names no "
                              "folder with calf_mri/labels.nii.gz.");
  if (has_data("head_ct/headsq.mha"))
    all.push_back({"bone of head CT", bone_of_head()});
  else
    report.notes.emplace_back("bone of the head omitted: MAILLE_DATA names no folder with "
                              "head_ct/headsq.mha.");
}

} // namespace

Scene gyroid_network(int cells, int period, double solid, double filling) {
  const std::vector<float> values = gyroid(cells, period);
  std::vector<float> sorted = values;
  const auto threshold =
      sorted.begin() + static_cast<std::ptrdiff_t>((1 - solid) * static_cast<double>(sorted.size()));
  std::ranges::nth_element(sorted, threshold);
  std::vector<std::uint8_t> labels;
  for (const float value : values)
    labels.push_back(value > *threshold ? 1 : 0);
  keep_largest_piece(labels, cells);
  constexpr double youngs_modulus = 10e9;
  SceneBuilder builder("gyroid");
  builder.material(1, isotropic("strut", youngs_modulus, 0.3));
  if (filling > 0) {
    std::ranges::replace(labels, std::uint8_t{0}, std::uint8_t{2});
    builder.material(2, isotropic("filling", filling * youngs_modulus, 0.3));
  }
  builder.labels(labels, ArrayLayout::x_fastest({cells, cells, cells}), affine_of({cell, cell, cell}))
      .hold("z-")
      .move("z+", {0, 0, -0.01 * cells * cell});
  return builder.build();
}

Scene layered_tissue(int cells) {
  const Index3 size{cells, cells, cells / 2};
  std::vector<std::uint8_t> labels;
  for (int z = 0; z < size[2]; ++z)
    labels.insert(labels.end(), static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells),
                  z + 1 == size[2]           ? std::uint8_t{3}
                  : z >= size[2] - cells / 6 ? std::uint8_t{2}
                                             : std::uint8_t{1});
  const double width = cells * cell, height = size[2] * cell;
  SceneBuilder builder("layers");
  builder.labels(labels, ArrayLayout::x_fastest(size), affine_of({cell, cell, cell}))
      .material(1, "muscle/vastus_lateralis")
      .material(2, "fat/subcutaneous")
      .material(3, "skin/dermis")
      .hold("z-")
      .move(BoxRegion{{3 * width / 8, 3 * width / 8, height}, {5 * width / 8, 5 * width / 8, height}},
            {0, 0, -cell});
  return elastic(builder.build());
}

Scene one_cell_strip(const BenchOptions& options) {
  SceneBuilder builder("one_cell_strip");
  builder.box(3, options.quick ? Index3{8, 4, 1} : Index3{32, 8, 1}, {cell, cell, cell})
      .material(isotropic("strip", 1e6, 0.45))
      .hold("x-")
      .traction("x+", {0, 0, 1});
  return builder.build();
}

Scene within_limits(Scene scene) {
  scene.limits = {};
  scene.limits.from = LimitSource::material;
  scene.limits.cut_is_allowed = true;
  return scene;
}

std::vector<Body> bodies(const BenchOptions& options, BenchReport& report) {
  const BodySizes sizes = BodySizes::of(options);
  std::vector<Body> all;
  all.push_back({"strip", of_repository("strip_pulled.toml"), true});
  all.push_back({"belly", of_repository("muscle_belly.toml"), true});
  if (!options.quick)
    add_images(all, report);
  all.push_back({"layers", layered_tissue(sizes.layers), true});
  all.push_back({"gyroid 64", gyroid_network(sizes.network, sizes.period, solid_share)});
  all.push_back({"gyroid 128", gyroid_network(sizes.large_network, sizes.period, solid_share), false, false});
  return all;
}

} // namespace maille::lab
