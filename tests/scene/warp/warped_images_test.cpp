/// Images, labels and fields of deformed bodies.
#include "maille/images/write_image.hpp"
#include "maille/scene/warp/warp.hpp"
#include "support/kit.hpp"
#include "warp/continuation.hpp"

#include "scene/warp/warp_bodies.hpp"

namespace maille {
namespace {

using test::ImagedBody;

ImagedBody block(const ImageInfo& grid) {
  return test::imaged_body(grid, [](int i, int j, int k) {
    return i > 2 && i < 9 && j > 2 && j < 8 && k > 2 && k < 7 ? (i < 6 ? 5 : 17) : 0;
  });
}

/// Truth: a ramp is carried along as the ramp of where matter came from.
TEST(WarpedAnalytic, LinearImagesAreExact) {
  ImagedBody body = block(test::oblique_grid({12, 11, 10}, {2e-3, 3e-3, 4e-3}));
  test::displace(body, [](const Vec3& x) { return Vec3{0.1 * x[0] + 1e-3, 0.15 * x[0], -0.05 * x[2]}; });
  Image ramp = body.labels;
  std::size_t voxel = 0;
  const auto at = [](double i, double j, double k) { return 3 + 2 * i - j + 0.5 * k; };
  for (const auto& [i, j, k] : test::all_below({12, 11, 10}))
    ramp.values[voxel++] = float(at(i, j, k));
  const Pull pull = pull_of(ramp.info, body.bodies());
  const Image after = warped(pull, ramp, -100);
  const auto n = pull.source.size();
  voxel = 0;
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 11; ++j)
      for (int i = 0; i < 12; ++i, ++voxel) {
        const double expected = pull.source[voxel] == Pull::nothing
                                    ? -100
                                    : at(i + double{pull.shift[voxel]}, j + double{pull.shift[n + voxel]},
                                         k + double{pull.shift[2 * n + voxel]});
        EXPECT_NEAR(after.values[voxel], expected, 1e-4);
      }
  EXPECT_GT(pull.reached, 100);
}

/// Truth: a body that is stretched to 1.5 and 2 times along two axes. All that can be said of it is known.
TEST(WarpedAnalytic, TheTableOfAStretchedBlockIsKnown) {
  ImagedBody body =
      test::imaged_body(test::grid_of({20, 20, 8}, {1e-3, 2e-3, 3e-3}), [](int i, int j, int k) {
        return i >= 2 && i < 10 && j >= 2 && j < 8 && k >= 2 && k < 6 ? (i < 6 ? 5 : 17) : i == 15 ? 30 : 0;
      });
  // The bone at i = 15 is no part of the body: build it again without.
  Image labels = body.labels;
  body = test::imaged_body(labels.info, [&](int i, int j, int k) {
    const float value = labels.values[std::size_t(i + 20 * (j + 20 * k))];
    return value == 30 ? 0 : int(value);
  });
  const Vec3 corner = body.scene.specimen.position({0, 0, 0});
  test::displace(body, [&](const Vec3& x) { return Vec3{0.5 * (x[0] - corner[0]), x[1] - corner[1], 0}; });
  const Pull pull = pull_of(labels.info, body.bodies());
  const Image after = warped_labels(pull, labels);
  const auto table =
      warped_label_table(pull, body.bodies(), labels, after, volume_ratio(labels.info, body.bodies()));
  ASSERT_EQ(table.size(), 3U);
  constexpr double voxel = 6e-9;
  for (std::size_t row = 0; row < 2; ++row) {
    EXPECT_EQ(table[row].label, row == 0 ? 5 : 17);
    EXPECT_EQ(table[row].voxels, 4 * 6 * 4);
    EXPECT_EQ(table[row].warped, 6 * 12 * 4);
    EXPECT_NEAR(table[row].volume_at_rest, 96 * voxel, 1e-18);
    EXPECT_NEAR(table[row].volume, 3 * 96 * voxel, 1e-18);
    EXPECT_NEAR(table[row].sub_voxel_volume, 3 * 96 * voxel, 1e-12 * 288 * voxel);
    EXPECT_NEAR(table[row].integral_of_det_f, 3 * 96 * voxel, 1e-7 * 288 * voxel);
    EXPECT_EQ(table[row].folded, 0);
    EXPECT_EQ(table[row].left_out, 0);
  }
  // Of 5 the middles go from 2, 3, 4, 5 to 2 ... 7; of 17 from 6 ... 9 to 8 ... 13. Middles at 0 are the
  // origin.
  EXPECT_NEAR(table[0].centroid_at_rest[0], 3.5e-3, 1e-12);
  EXPECT_NEAR(table[0].centroid[0], 4.5e-3, 1e-12);
  EXPECT_NEAR(table[1].centroid[0], 10.5e-3, 1e-12);
  EXPECT_NEAR(table[1].centroid[1], 2e-3 * 7.5, 1e-12);
  EXPECT_NEAR(table[1].centroid[2], 3e-3 * 3.5, 1e-12);
  EXPECT_EQ(table[2].label, 30);
  EXPECT_EQ(table[2].voxels, 0);
  EXPECT_EQ(table[2].left_out, 20 * 8);
  EXPECT_EQ(table[2].warped, 0);
}

/// Truth: the determinant of a uniform deformation times the volume at rest. Faces between middles of
/// voxels are where counting of middles fails: it is more than 2 % off here.
TEST(WarpedAnalytic, SubVoxelVolumesAreThoseOfMatterWhereverItsFacesLie) {
  const auto label_at = [](int i, int j, int k) {
    return i >= 6 && i < 18 && j >= 6 && j < 18 && k >= 6 && k < 15 ? (i + j < 24 ? 5 : 17) : 0;
  };
  double worst_counted = 0;
  for (const double turn : {0.0, 0.3})
    for (const bool is_oblique : {false, true}) {
      ImagedBody body = test::imaged_body(is_oblique ? test::oblique_grid({24, 24, 22}, {2e-3, 3e-3, 4e-3})
                                                     : test::grid_of({24, 24, 22}, {1e-3, 1e-3, 1e-3}),
                                          label_at);
      const Vec3 low = body.scene.specimen.position({0, 0, 0});
      const Vec3 h = body.scene.specimen.grid.spacing();
      test::displace(body, [&](const Vec3& x) {
        const double a = x[0] - low[0], b = x[1] - low[1], c = x[2] - low[2];
        return Vec3{0.031 * a - turn * b * h[0] / h[1] + 0.3 * h[0],
                    turn * a * h[1] / h[0] - 0.027 * b - 0.2 * h[1], 0.043 * c + 0.1 * h[2]};
      });
      const double det_f = (1.031 * 0.973 + turn * turn) * 1.043;
      const Pull pull = pull_of(body.labels.info, body.bodies());
      const auto table =
          warped_label_table(pull, body.bodies(), body.labels, warped_labels(pull, body.labels),
                             volume_ratio(body.labels.info, body.bodies()));
      ASSERT_EQ(table.size(), 2U);
      for (const WarpedLabel& row : table) {
        const double truth = det_f * row.volume_at_rest;
        EXPECT_NEAR(row.sub_voxel_volume, truth, 0.002 * truth) << row.label << " turned by " << turn;
        worst_counted = std::max(worst_counted, std::abs(row.volume / truth - 1));
      }
    }
  EXPECT_GT(worst_counted, 0.02) << "the case no longer shows why parts are counted";
}

/// Truth: every voxel's 8^3 points asked by the pull of a finer grid. Cells are shaken, so that all differ.
TEST(WarpedOracle, SubVoxelVolumesAreThoseOfAFinerGrid) {
  ImagedBody body = block(test::oblique_grid({12, 11, 10}, {2e-3, 3e-3, 4e-3}));
  test::shake(body, 0.2, 7);
  constexpr int fine = 8;
  ImageInfo grid = body.labels.info;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.size[a] *= fine;
    grid.spacing[a] /= fine;
  }
  for (std::size_t r = 0; r < 3; ++r) // the middle of the first fine voxel
    for (std::size_t a = 0; a < 3; ++a)
      grid.origin[r] -= grid.direction[r][a] * grid.spacing[a] * (fine - 1) / 2;
  const Pull finer = pull_of(grid, body.bodies());
  std::map<float, double> truth;
  for (const std::int32_t source : finer.source)
    if (source >= 0) {
      const int i = source % grid.size[0] / fine, j = source / grid.size[0] % grid.size[1] / fine,
                k = source / grid.size[0] / grid.size[1] / fine;
      truth[body.labels.values[std::size_t(i + 12 * (j + 11 * k))]] += 24e-9 / (fine * fine * fine);
    }
  const Pull pull = pull_of(body.labels.info, body.bodies());
  for (const WarpedLabel& row :
       warped_label_table(pull, body.bodies(), body.labels, warped_labels(pull, body.labels),
                          volume_ratio(body.labels.info, body.bodies())))
    EXPECT_NEAR(row.sub_voxel_volume, truth[float(row.label)], 0.003 * row.volume_at_rest);
}

/// Truth: a shift, in the world. Pull leads back and push forth, along left, posterior, superior; and what
/// the body leaves must not be seen a second time.
TEST(FieldsAnalytic, OfAShiftAreThatShiftInLps) {
  ImagedBody body = block(test::oblique_grid({14, 13, 10}, {2e-3, 3e-3, 4e-3}));
  const Vec3 by{4e-3, -3e-3, 2e-3}; // object's frame
  test::displace(body, [&](const Vec3&) { return by; });
  const Vec3 ras = to_world(body.scene.specimen.placement, by);
  const Vec3 lps{-1e3 * ras[0], -1e3 * ras[1], 1e3 * ras[2]}; // mm
  const Pull pull = pull_of(body.labels.info, body.bodies());
  const Image back = pull_field(pull, body.bodies()), forth = push_field(body.labels.info, body.bodies());
  const auto n = pull.source.size();
  ASSERT_EQ(back.values.size(), 3 * n);
  for (std::size_t voxel = 0; voxel < n; ++voxel)
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(back.values[a * n + voxel], -lps[a], 2e-5);
      EXPECT_NEAR(forth.values[a * n + voxel], lps[a], 2e-5);
    }
}

/// Half a turn: what goes on as the nearest matter does would show the body itself where it was.
TEST(FieldsAnalytic, LeadOutOfTheImageWhereMatterWouldBeSeenTwice) {
  ImagedBody body = test::imaged_body(test::grid_of({16, 9, 3}, {1e-3, 1e-3, 1e-3}), [](int i, int j, int) {
    return i >= 1 && i < 5 && j >= 3 && j < 6 ? 1 : 0;
  });
  // Mirrored about x = 5 voxels and shifted: every second layer keeps its sense, so nothing is folded.
  const double axis = 5e-3;
  test::displace(body, [&](const Vec3& x) {
    return Vec3{2 * (axis - x[0]), 2 * (4.5e-3 - x[1]), 0}; // half a turn about z
  });
  const Pull pull = pull_of(body.labels.info, body.bodies());
  ASSERT_EQ(pull.folded_cells, 0);
  EXPECT_EQ(pull.vacated, 36);
  const Image field = pull_field(pull, body.bodies());
  const auto n = pull.source.size();
  for (std::size_t voxel = 0; voxel < n; ++voxel) {
    if (pull.source[voxel] != Pull::nothing)
      continue;
    // No voxel without matter may come from where the body was: in voxels, LPS turns x and y round.
    const double i = double(voxel % 16) - double{field.values[voxel]};
    const double j = double(voxel / 16 % 9) - double{field.values[n + voxel]};
    EXPECT_FALSE(i > 0.5 && i < 4.5 && j > 2.5 && j < 5.5) << voxel;
  }
}

/// Truth: all known voxels are tried.
TEST(ContinuationOracle, IsAKnownVoxelOfTheFewestSteps) {
  const Index3 size{9, 7, 5};
  std::mt19937 random(3);
  std::vector<bool> is_known(9 * 7 * 5);
  for (std::size_t i = 0; i < is_known.size(); ++i)
    is_known[i] = random() % 40 == 0;
  std::vector<std::int32_t> known(is_known.size(), -1);
  for (std::size_t i = 0; i < is_known.size(); ++i)
    if (is_known[i])
      known[i] = static_cast<std::int32_t>(i);
  const auto nearest = warping::nearest_known(size, known);
  const auto steps = [&](std::size_t a, std::size_t b) {
    const auto part = [](std::size_t v, std::size_t div, std::size_t mod) { return int(v / div % mod); };
    return std::abs(part(a, 1, 9) - part(b, 1, 9)) + std::abs(part(a, 9, 7) - part(b, 9, 7)) +
           std::abs(part(a, 63, 5) - part(b, 63, 5));
  };
  for (std::size_t voxel = 0; voxel < is_known.size(); ++voxel) {
    int least = 1000;
    for (std::size_t other = 0; other < is_known.size(); ++other)
      if (is_known[other])
        least = std::min(least, steps(voxel, other));
    ASSERT_GE(nearest[voxel], 0);
    EXPECT_TRUE(is_known[std::size_t(nearest[voxel])]);
    EXPECT_EQ(steps(voxel, std::size_t(nearest[voxel])), least);
  }
  EXPECT_EQ(warping::nearest_known(size, std::vector<std::int32_t>(is_known.size(), -1))[0], -1);
}

/// Truth: of two voxels at the ends of a long row each has the half next to it.
TEST(ContinuationAnalytic, LongWaysAreCountedToTheirEnd) {
  for (const int n : {101, 16'401, 33'001}) {
    const Index3 size{3, 2, n};
    std::vector<std::int32_t> known(6 * std::size_t(n), -1);
    const auto last = static_cast<std::int32_t>(known.size() - 1);
    known.front() = 0;
    known.back() = last;
    const auto nearest = warping::nearest_known(size, known);
    std::size_t voxel = 0;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 3; ++i, ++voxel) {
          const int to_first = i + j + k, to_last = 2 - i + 1 - j + n - 1 - k;
          if (to_first == to_last)
            continue;
          ASSERT_EQ(nearest[voxel], to_first < to_last ? 0 : last) << i << " " << j << " " << k;
        }
  }
}

/// Truth: what was written, as our readers read it, whose numbers other tests hold against the formats.
TEST(WriteImageContract, EveryFormatHasTheGridAndTheValues) {
  const test::TemporaryFolder folder;
  for (const WorldAxes world : {WorldAxes::ras, WorldAxes::lps}) {
    Image image = block(test::oblique_grid({12, 11, 10}, {2e-3, 3e-3, 4e-3})).labels;
    image.info.world = world;
    Image field = image;
    field.info.components = 3;
    field.values.clear();
    for (int i = 0; i < 3 * 12 * 11 * 10; ++i)
      field.values.push_back(float(0.5 * i));
    for (const char* name : {"a.nii", "a.nii.gz", "a.mha"}) {
      const auto file = folder.path() / name;
      for (const bool is_field : {false, true}) {
        const Image& written = is_field ? field : image;
        write_image(written, file, {is_field ? StoredAs::float32 : StoredAs::labels, {}});
        const Image read = read_image(file);
        EXPECT_EQ(read.values, written.values) << name;
        EXPECT_EQ(read.info.world, std::string(name).ends_with(".mha") ? WorldAxes::lps : WorldAxes::ras);
        const double turned = read.info.world == world ? 1 : -1;
        for (std::size_t r = 0; r < 3; ++r) {
          EXPECT_NEAR(read.info.origin[r], (r < 2 ? turned : 1) * written.info.origin[r], 1e-8);
          for (std::size_t a = 0; a < 3; ++a)
            EXPECT_NEAR(read.info.direction[r][a], (r < 2 ? turned : 1) * written.info.direction[r][a], 1e-6);
        }
      }
    }
  }
}

TEST(WriteImageContract, RefusesWhatAFileCannotHold) {
  const test::TemporaryFolder folder;
  Image image = block(test::grid_of({12, 11, 10}, {1e-3, 1e-3, 1e-3})).labels;
  EXPECT_THROW(write_image(image, folder.path() / "a.png"), std::invalid_argument);
  image.values[3] = 0.5F;
  EXPECT_THROW(write_image(image, folder.path() / "a.nii", {StoredAs::labels, {}}), std::invalid_argument);
  image.values.pop_back();
  EXPECT_THROW(write_image(image, folder.path() / "a.mha"), std::invalid_argument);
  EXPECT_THROW(write_image(image, folder.path() / "no" / "a.nii"), std::exception);
}

} // namespace
} // namespace maille
