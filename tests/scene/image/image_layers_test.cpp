/// Bodies that are read layer by layer, against the obvious way: the whole image at once, cell by cell.
#include "maille/images/layers.hpp"
#include "maille/images/write_image.hpp"
#include "maille/scene/fibre/fibre_field.hpp"
#include "maille/scene/read_scene.hpp"
#include "read/reader.hpp"
#include "scene/image/image_writers.hpp"
#include "support/kit.hpp"

#include <Eigen/Dense>
#include <sys/resource.h>

namespace maille {
namespace {

using image_tests::TemporaryFolder;

/// Balls of labels 1 to 6, with stray voxels.
Image random_labels(std::mt19937& random, int n_layers_at_most = 21) {
  const auto up_to = [&](int n) { return int(random() % unsigned(n)); };
  Image image;
  image.info.size = {1 + up_to(22), 1 + up_to(19), 1 + up_to(n_layers_at_most)};
  image.info.spacing = {1e-3, 0.9e-3, 1.3e-3};
  image.info.origin = {1e-3, 2e-3, 3e-3};
  image.info.world = WorldAxes::lps;
  image.values.assign(std::size_t(image.info.n_voxels()), 0);
  const Index3 n = image.info.size;
  for (int ball = 0; ball < 5; ++ball) {
    const Index3 middle{up_to(n[0]), up_to(n[1]), up_to(n[2])};
    const int radius = 2 + up_to(8), label = 1 + up_to(6);
    for (std::size_t v = 0; v < image.values.size(); ++v) {
      const int voxel = int(v);
      const int x = voxel % n[0] - middle[0], y = voxel / n[0] % n[1] - middle[1],
                z = voxel / n[0] / n[1] - middle[2];
      if (x * x + y * y + z * z < radius * radius)
        image.values[v] = float(label);
    }
  }
  for (float& value : image.values)
    if (up_to(25) == 0)
      value = float(up_to(7));
  return image;
}

/// What a scene's text says: which material a grey value is, and what of a voxel is tissue.
struct Asked {
  std::string labels;
  std::map<float, int> material; ///< of grey values
  std::array<int, 3> coarsen{1, 1, 1};
  std::string partial;
  double least = 0;
  std::function<std::vector<double>(const Image&, const std::map<float, int>&)>
      shares; ///< none: all or nothing
};

constexpr int none = -1;
/// All of the body: no piece of it is loose.
constexpr const char* hold = "[[hold]]\nwhere = { sphere = { centre = [0, 0, 0], radius = \"10 m\" } }\n";

/// Cells of the whole image.
struct Whole {
  Index3 cells{};
  std::vector<int> material;
  std::vector<double> tissue;
  std::vector<float> label;
};

int material_at(const Asked& asked, float value) {
  const auto found = asked.material.find(value);
  return found == asked.material.end() ? none : found->second;
}

/// Voxels of a cell and `margin` around it.
std::vector<std::size_t> voxels_of(const Image& image, const Asked& asked, const Index3& cell, int margin) {
  std::vector<std::size_t> voxels;
  const Index3& n = image.info.size;
  for (const auto& [i, j, k] : test::all_below(n)) {
    const Index3 at{i, j, k};
    bool is_in = true;
    for (std::size_t a = 0; a < 3; ++a)
      is_in = is_in && at[a] >= cell[a] * asked.coarsen[a] - margin &&
              at[a] < (cell[a] + 1) * asked.coarsen[a] + margin;
    if (is_in)
      voxels.push_back(std::size_t(i + n[0] * (j + n[1] * k)));
  }
  return voxels;
}

/// The most frequent key, the first among equals; nothing if empty.
template<class Key>
std::optional<Key> most_of(const std::map<Key, int>& count) {
  std::optional<Key> most;
  for (const auto& [key, n] : count)
    if (!most || n > count.at(*most))
      most = key;
  return most;
}

/// What voxels around a cell have most often, of the nearest that have any.
template<class Key, class Of>
Key nearest_most(const Image& image, const Asked& asked, const Index3& cell, Key otherwise, Of&& of) {
  for (int margin = 0; margin <= 8; ++margin) {
    std::map<Key, int> count;
    for (const std::size_t voxel : voxels_of(image, asked, cell, margin))
      if (const auto key = of(image.values[voxel]))
        ++count[*key];
    if (const auto most = most_of(count))
      return *most;
  }
  return otherwise;
}

Whole whole_body(const Image& image, const Asked& asked) {
  Whole body;
  for (std::size_t a = 0; a < 3; ++a)
    body.cells[a] = (image.info.size[a] + asked.coarsen[a] - 1) / asked.coarsen[a];
  const double full = asked.coarsen[0] * asked.coarsen[1] * asked.coarsen[2];
  const auto shares = asked.shares ? asked.shares(image, asked.material) : std::vector<double>{};
  const auto material_of_matter = [&](float value) {
    const int material = material_at(asked, value);
    return material == none ? std::nullopt : std::optional(material);
  };
  for (const auto& [i, j, k] : test::all_below(body.cells)) {
    const Index3 cell{i, j, k};
    std::map<int, int> count;
    int matter = 0;
    double share = 0;
    for (const std::size_t voxel : voxels_of(image, asked, cell, 0)) {
      if (const auto material = material_of_matter(image.values[voxel])) {
        ++count[*material];
        ++matter;
      }
      share += shares.empty() ? 0 : shares[voxel] / full;
    }
    int material = 2 * matter >= full ? *most_of(count) : none;
    if (!shares.empty() && share < asked.least)
      material = none;
    else if (!shares.empty() && material == none)
      material = nearest_most(image, asked, cell, 0, material_of_matter);
    body.material.push_back(material);
    body.tissue.push_back(material == none ? 0 : share);
    body.label.push_back(material == none ? 0 : nearest_most(image, asked, cell, 0.0F, [&](float value) {
      return material_at(asked, value) == material ? std::optional(value) : std::nullopt;
    }));
  }
  return body;
}

std::string text_of(const Asked& asked, const std::string& more = "") {
  return fmt::format("[specimen]\nshape = \"image\"\nimage = \"FILE\"\n{}\ncoarsen = [{}, {}, {}]\n{}\n{}\n"
                     "{}",
                     asked.labels, asked.coarsen[0], asked.coarsen[1], asked.coarsen[2], asked.partial, more,
                     hold);
}

Scene scene_of(std::string text, const std::filesystem::path& file) {
  text.replace(text.find("FILE"), 4, file.string());
  return parse_scene(text, file.parent_path() / "scene.toml");
}

/// @param tissue_within how far parts of tissue may be apart
void expect_body(const Specimen& body, const Whole& whole, double tissue_within = 1e-6) {
  Index3 first{};
  for (std::size_t a = 0; a < 3; ++a)
    first[a] = int(std::lround(body.origin[a] / body.grid.spacing()[a]));
  std::array<std::set<int>, 3> with_matter;
  std::size_t cell = 0;
  for (const auto& [i, j, k] : test::all_below(whole.cells)) {
    const std::size_t c = cell++;
    const Index3 at{i - first[0], j - first[1], k - first[2]};
    SCOPED_TRACE(fmt::format("{} {} {}", i, j, k));
    const bool is_there = body.grid.has_cell(at);
    const bool is_matter = is_there && body.is_matter(body.grid.cell(at));
    ASSERT_EQ(is_matter, whole.material[c] != none);
    if (!is_matter)
      continue;
    for (std::size_t a = 0; a < 3; ++a)
      with_matter[a].insert(at[a]);
    const auto n = std::size_t(body.grid.cell(at));
    EXPECT_EQ(int{body.material(body.grid.cell(at))}, whole.material[c]);
    EXPECT_TRUE(body.label.empty() || float(body.label[n]) == whole.label[c]);
    EXPECT_NEAR(body.tissue.empty() ? whole.tissue[c] : double{body.tissue[n]}, whole.tissue[c],
                tissue_within);
  }
  for (std::size_t a = 0; a < 3; ++a) { // cut down to its matter
    EXPECT_EQ(*with_matter[a].begin(), 0);
    EXPECT_EQ(*with_matter[a].rbegin(), body.grid.cells()[a] - 1);
  }
}

std::vector<Asked> all_kinds(std::mt19937& random) {
  const auto block = [&] {
    const auto n = [&] { return 1 + int(random() % 4); };
    return std::array{n(), n(), n()};
  };
  const std::map<float, int> ranges{{1, 0}, {2, 0}, {3, 0}, {4, 1}, {5, 2}, {6, 2}}, some{{2, 0}, {5, 1}},
      all{{1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}, {6, 0}};
  const std::string of_ranges = "labels = { \"1..3\" = \"muscle/soleus\", 4 = \"bone/cortical_tibia\", "
                                "\"5..6\" = \"muscle/gastrocnemius\" }\nfibre = [1, 0, 0]",
                    of_some =
                        "labels = { 2 = \"muscle/soleus\", 5 = \"bone/cortical_tibia\" }\nfibre = [1, 0, 0]",
                    of_all = "material = \"muscle/soleus\"\nfibre = [1, 0, 0]";
  const auto shares_of_labels = [](const Image& image, const std::map<float, int>& material) {
    std::vector<double> shares;
    for (const float value : image.values)
      shares.push_back(material.contains(value) ? 1 : 0);
    return shares;
  };
  const auto shares_of_grey = [](const Image& image, const std::map<float, int>&) {
    std::vector<double> shares;
    for (const float value : image.values)
      shares.push_back(std::min(value / 5.0, 1.0));
    return shares;
  };
  return {{of_ranges, ranges, {1, 1, 1}, "", 0, {}},
          {of_ranges, ranges, block(), "", 0, {}},
          {of_some, some, block(), "", 0, {}},
          {of_all, all, block(), "", 0, {}},
          {of_ranges, ranges, {2, 2, 2}, "partial_volume = true", 0.05, shares_of_labels},
          {of_some, some, {4, 3, 3}, "partial_volume = true", 0.05, shares_of_labels},
          {of_some, some, block(), "partial_volume = { none = 0, full = 5, least = 0.11 }", 0.11,
           shares_of_grey}};
}

TEST(ImageLayersOracle, ABodyIsThatOfTheWholeImage) {
  const TemporaryFolder folder;
  std::mt19937 random(5);
  int bodies = 0;
  for (int round = 0; round < 18; ++round) {
    const Image image = random_labels(random, round == 0 ? 1 : 21);
    const auto file = folder.path() / "labels.nrrd";
    write_image(image, file, {StoredAs::labels, {}});
    for (const Asked& asked : all_kinds(random)) {
      SCOPED_TRACE(fmt::format("round {}: {}", round, text_of(asked)));
      const Whole whole = whole_body(image, asked);
      const bool occur = std::ranges::all_of(asked.material, [&](const auto& of) {
        return std::ranges::count(image.values, of.first) > 0 &&
               std::ranges::count(whole.material, of.second) > 0;
      });
      if (!occur || std::ranges::count(whole.material, none) == std::ssize(whole.material))
        continue;
      expect_body(scene_of(text_of(asked), file).specimen, whole);
      std::string text = text_of(asked);
      text.erase(0, text.find("FILE") + 6);
      const Scene given = reader::scene_of(parse_toml("[specimen]\n" + text, ""), "scene.toml", &image).scene;
      expect_body(given.specimen, whole);
      ++bodies;
    }
  }
  EXPECT_GT(bodies, 40);
}

TEST(ImageLayersOracle, EveryFormatGivesTheSameBody) {
  const TemporaryFolder folder;
  std::mt19937 random(8);
  Image image;
  Asked asked;
  Whole whole;
  do { // until both labels have cells
    image = random_labels(random);
    image.info.size = {13, 11, 9};
    image.values.resize(13 * 11 * 9, 5);
    asked = all_kinds(random)[2];
    whole = whole_body(image, asked);
  } while (std::ranges::count(whole.material, 0) == 0 || std::ranges::count(whole.material, 1) == 0);
  std::string bytes;
  for (const float value : image.values)
    bytes += char(value);
  const std::string meta =
      "NDims = 3\nDimSize = 13 11 9\nElementSpacing = 1 0.9 1.3\nElementType = MET_UCHAR\n";
  const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 13 11 9\nspacings: 1 0.9 1.3\n";
  std::vector<std::filesystem::path> files{
      folder.write("raw.mha", meta + "ElementDataFile = LOCAL\n" + bytes),
      folder.write("zlib.mha", meta + "CompressedData = True\nElementDataFile = LOCAL\n" +
                                   image_tests::deflated(bytes, false)),
      folder.write("gzip.nrrd", nrrd + "encoding: gzip\n\n" + image_tests::deflated(bytes, true)),
      folder.write("cells.vti",
                   "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\"><ImageData "
                   "WholeExtent=\"0 13 0 11 0 9\" Origin=\"0 0 0\" Spacing=\"1 0.9 1.3\"><Piece "
                   "Extent=\"0 13 0 11 0 9\"><CellData><DataArray type=\"UInt8\" "
                   "format=\"binary\">" +
                       image_tests::base64(
                           image_tests::bytes_of<std::uint32_t>(std::uint32_t(bytes.size()), false) + bytes) +
                       "</DataArray></CellData></Piece></ImageData></VTKFile>")};
  for (const char* name : {"a.nii", "a.nii.gz", "a.mha", "a.nrrd"}) {
    files.push_back(folder.path() / name);
    write_image(image, files.back(), {name[2] == 'n' ? StoredAs::labels : StoredAs::float32, {}});
  }
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename().string());
    EXPECT_EQ(read_image(file).values, image.values);
    expect_body(scene_of(text_of(asked), file).specimen, whole);
  }
}

/// The same with void around it; in a plane where it has one layer.
Image in_void(const Image& image, int voids) {
  Image around{image.info, {}};
  for (std::size_t a = 0; a < 3; ++a)
    around.info.size[a] += a < 2 || image.info.size[2] > 1 ? 2 * voids : 0;
  const Index3 &n = around.info.size, &inner = image.info.size;
  const int below = inner[2] > 1 ? voids : 0;
  for (int k = -below; k < n[2] - below; ++k)
    for (int j = -voids; j < n[1] - voids; ++j)
      for (int i = -voids; i < n[0] - voids; ++i) {
        const bool is_in = std::min({i, j, k}) >= 0 && i < inner[0] && j < inner[1] && k < inner[2];
        around.values.push_back(is_in ? image.values[std::size_t(i + inner[0] * (j + inner[1] * k))] : 0);
      }
  return around;
}

/// The mean of values about each voxel, weighed by a Gaussian out to three of its widths, in an image
/// with void at its border.
std::vector<double> smoothed(const std::vector<double>& values, const ImageInfo& info, double width) {
  const Index3& n = info.size;
  std::array<int, 3> reach{};
  for (std::size_t a = 0; a < 3; ++a)
    reach[a] = n[a] == 1 ? 0 : int(std::ceil(3 * width / info.spacing[a]));
  std::vector<double> mean;
  for (const auto& [i, j, k] : test::all_below(n)) {
    double sum = 0, weights = 0;
    for (int z = -reach[2]; z <= reach[2]; ++z)
      for (int y = -reach[1]; y <= reach[1]; ++y)
        for (int x = -reach[0]; x <= reach[0]; ++x) {
          const double distance =
              std::hypot(x * info.spacing[0], y * info.spacing[1], z * info.spacing[2]) / width;
          const double weight = std::exp(-distance * distance / 2);
          sum += weight * values[std::size_t(std::clamp(i + x, 0, n[0] - 1) +
                                             n[0] * (std::clamp(j + y, 0, n[1] - 1) +
                                                     n[1] * std::clamp(k + z, 0, n[2] - 1)))];
          weights += weight;
        }
    mean.push_back(sum / weights);
  }
  return mean;
}

/// Of 4 x 4 x 4 points of each voxel, how many are among the highest, of as many as `labels` have, where
/// values are linear between voxels; in voxels of labels and in those with a point above a half.
std::vector<double> highest_shares(const std::vector<double>& values, const std::vector<double>& labels,
                                   const Index3& n) {
  const auto weight_of = [&](int voxel, double at, int size) {
    const double inside = std::clamp(at, 0.0, size - 1.0);
    return std::max(0.0, 1 - std::abs(voxel - inside));
  };
  std::vector<std::pair<double, std::size_t>> points; // values, voxels
  std::vector<double> shares(values.size(), 0);
  std::size_t voxel = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i, ++voxel) {
        double highest = labels[voxel];
        for (int point = 0; point < 64; ++point) {
          const Vec3 at{i + (point % 4 - 1.5) / 4, j + (point / 4 % 4 - 1.5) / 4,
                        n[2] == 1 ? 0.0 : k + (point / 16 - 1.5) / 4};
          double value = 0;
          for (int z = std::max(k - 1, 0); z <= std::min(k + 1, n[2] - 1); ++z)
            for (int y = std::max(j - 1, 0); y <= std::min(j + 1, n[1] - 1); ++y)
              for (int x = std::max(i - 1, 0); x <= std::min(i + 1, n[0] - 1); ++x)
                value += weight_of(x, at[0], n[0]) * weight_of(y, at[1], n[1]) * weight_of(z, at[2], n[2]) *
                         values[static_cast<std::size_t>(x + n[0] * (y + n[1] * z))];
          points.emplace_back(value, voxel);
          highest = std::max(highest, value);
        }
        if (highest <= 0.5)
          points.resize(points.size() - 64);
      }
  // Points near to the level, within 1 in 128 of it, share what is left.
  std::ranges::sort(points, std::greater{});
  double wanted = 64.0 * static_cast<double>(std::ranges::count(labels, 1));
  const double level = points[static_cast<std::size_t>(wanted) - 1].first,
               width = std::exp2(std::floor(std::log2(level)) - 7), low = std::floor(level / width) * width;
  const auto near = [&](const auto& point) { return point.first >= low && point.first < low + width; };
  const auto n_near = static_cast<double>(std::ranges::count_if(points, near));
  for (const auto& [value, of] : points)
    wanted -= value >= low + width ? 1 : 0;
  for (const auto& point : points)
    shares[point.second] += (near(point) ? wanted / n_near : point.first > low ? 1 : 0) / 64;
  return shares;
}

// Points where float32 and float64 are on two sides of the level are few: one of a cell is allowed for.
TEST(ImageLayersOracle, ASmoothSurfaceIsThatOfTheWholeImage) {
  const TemporaryFolder folder;
  std::mt19937 random(11);
  for (int round = 0; round < 6; ++round) {
    const Image image = in_void(random_labels(random, round == 0 ? 1 : 12), 4);
    const double width = 0.4e-3 + 0.1e-3 * round; // up to a voxel
    Asked asked = all_kinds(random)[3];
    asked.partial = fmt::format("partial_volume = {{ smooth = \"{} m\", least = 0.29 }}", width);
    asked.least = 0.29;
    asked.shares = [&](const Image& of, const std::map<float, int>& material) {
      std::vector<double> labels;
      for (const float value : of.values)
        labels.push_back(material.contains(value) ? 1 : 0);
      std::vector<double> once = smoothed(labels, of.info, width);
      const std::vector<double> twice = smoothed(once, of.info, width);
      for (std::size_t v = 0; v < once.size(); ++v)
        once[v] = 2 * once[v] - twice[v];
      return highest_shares(once, labels, of.info.size);
    };
    SCOPED_TRACE(text_of(asked));
    const auto file = folder.path() / "labels.mha";
    write_image(image, file, {StoredAs::labels, {}});
    Whole whole = whole_body(image, asked);
    double lost = static_cast<double>(image.values.size() - std::ranges::count(image.values, 0)), room = 0;
    for (const double part : whole.tissue) { // cells on the surface take over what cells below `least` had
      lost -= part * asked.coarsen[0] * asked.coarsen[1] * asked.coarsen[2];
      room += part * (1 - part) * asked.coarsen[0] * asked.coarsen[1] * asked.coarsen[2];
    }
    for (double& part : whole.tissue)
      part += std::min(lost / room, 1.0) * part * (1 - part);
    expect_body(scene_of(text_of(asked), file).specimen, whole, 1.01 / 64);
  }
}

TEST(ImageLayersOracle, FibresAreThoseOfTheTensorsOfACellsOwnLabel) {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Image image = random_labels(random);
  while (std::ranges::count(image.values, 2) < 40 || std::ranges::count(image.values, 5) < 40)
    image = random_labels(random);
  Asked asked = all_kinds(random)[2];
  asked.coarsen = {2, 3, 2};
  asked.labels = asked.labels.substr(0, asked.labels.find("\nfibre"));
  const Whole whole = whole_body(image, asked);
  const auto n = std::size_t(image.info.n_voxels());
  Image tensors{image.info, std::vector<float>(6 * n)};
  tensors.info.components = 6;
  std::vector<Eigen::Matrix3d> of_voxel;
  for (std::size_t v = 0; v < n; ++v) {
    Eigen::Matrix3d half;
    for (int entry = 0; entry < 9; ++entry)
      half(entry / 3, entry % 3) = normal(random);
    const Eigen::Matrix3d t = half * half.transpose() + 0.1 * Eigen::Matrix3d::Identity();
    const std::array<double, 6> values{t(0, 0), t(1, 1), t(2, 2), t(0, 1), t(0, 2), t(1, 2)};
    for (std::size_t c = 0; c < 6; ++c)
      tensors.values[c * n + v] = float(values[c]);
    of_voxel.push_back(t);
  }
  write_image(image, folder.path() / "labels.mha", {StoredAs::labels, {}});
  write_image(tensors, folder.path() / "tensors.mha");
  const Scene scene =
      scene_of(text_of(asked, "fibre = { tensor_image = \"tensors.mha\" }"), folder.path() / "labels.mha");
  const Specimen& body = scene.specimen;
  expect_body(body, whole);
  Index3 first{};
  for (std::size_t a = 0; a < 3; ++a)
    first[a] = int(std::lround(body.origin[a] / body.grid.spacing()[a]));
  int cells = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    Index3 at = body.grid.cell_at(cell);
    for (std::size_t a = 0; a < 3; ++a)
      at[a] += first[a];
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const std::size_t voxel : voxels_of(image, asked, at, 0))
      if (image.values[voxel] == float(body.label[std::size_t(cell)]))
        sum += of_voxel[voxel];
    const Eigen::Vector3d direction =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors().col(2);
    const Vec3 fibre = body.fibre_of(cell);
    EXPECT_NEAR(std::abs(direction.dot(Eigen::Vector3d(fibre[0], fibre[1], fibre[2]))), 1, 1e-5);
    ++cells;
  }
  EXPECT_EQ(body.fibre_report.cells, cells);
  EXPECT_EQ(body.fibre_report.without_direction(), 0);
}

TEST(ImageLayersContract, AWindowReadsEachLayerOnce) {
  ImageInfo info;
  info.size = {3, 2, 40};
  int asked = 0;
  LayerWindow window(info, [&](int layer, std::vector<float>& values) {
    EXPECT_EQ(layer, asked++);
    for (int i = 0; i < 6; ++i)
      values.push_back(float(6 * layer + i));
  });
  std::mt19937 random(1);
  for (int low = -3; low < 44; low += int(random() % 4)) {
    const int high = low + int(random() % 9);
    window.move_to(low, high);
    EXPECT_LE(asked, 40);
    for (int k = std::max(low, 0); k < std::min(high, 40); ++k)
      for (std::size_t i = 0; i < 6; ++i) {
        const std::size_t voxel = 6 * std::size_t(k) + i;
        EXPECT_EQ(window[voxel], float(voxel));
        EXPECT_EQ(window.layer(k)[i], float(voxel));
      }
  }
}

// The body ends where its first layers do; what is wrong with a file is at its end.
TEST(ImageLayersContract, DamageBehindTheBodyIsAFault) {
  const TemporaryFolder folder;
  const std::string header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 9 8 40\nspacings: 1 1 1\n";
  const std::string bytes = std::string(9 * 8 * 2, '\1') + std::string(9 * 8 * 38, '\0');
  const std::string packed = header + "encoding: gzip\n\n" + image_tests::deflated(bytes, true);
  const auto whole = folder.write("whole.nrrd", packed);
  folder.write("cut.nrrd", packed.substr(0, packed.size() - 4));
  const auto faults_of = [&](const std::string& image, const std::string& stiffness,
                             const std::string& mask) {
    std::string text = "[specimen]\nshape = \"image\"\nimage = \"" + image +
                       "\"\nmaterial = \"fat/subcutaneous\"\n" + "stiffness = { image = \"" + stiffness +
                       "\", unit = \"kPa\" }\n[[hold]]\nwhere = { image = \"" + mask + "\" }\n";
    return image_tests::keys_of(
        test::faults_found_by([&] { parse_scene(text, folder.path() / "scene.toml"); }));
  };
  EXPECT_EQ(faults_of("whole.nrrd", "whole.nrrd", "whole.nrrd"), "");
  EXPECT_EQ(faults_of("whole.nrrd", "cut.nrrd", "whole.nrrd"), "specimen.stiffness");
  EXPECT_EQ(faults_of("whole.nrrd", "whole.nrrd", "cut.nrrd"), "hold[1].where.image");
  EXPECT_EQ(faults_of("cut.nrrd", "whole.nrrd", "whole.nrrd"), "specimen.image");
}

// 256 MiB of bytes, which are a GiB of float32; of the file all but a plate are holes.
TEST(ImageLayersContract, AnImageTakesTheMemoryOfSomeLayers) {
  const TemporaryFolder folder;
  const std::string header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1024 1024 256\nspacings: 1 1 1\n"
                             "encoding: raw\n\n";
  const auto file = folder.write("large.nrrd", header);
  std::filesystem::resize_file(file, header.size() + (std::size_t{1} << 28));
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  stream.seekp(static_cast<std::streamoff>(header.size() + (std::size_t{100} << 20)));
  stream << std::string(std::size_t{4} << 20, '\1');
  stream.close();
  const auto peak = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return std::int64_t{usage.ru_maxrss} * 1024;
  };
  const std::int64_t before = peak();
  const Scene scene = scene_of("[specimen]\nshape = \"image\"\nimage = \"FILE\"\ncoarsen = 4\n"
                               "labels = { 1 = \"fat/subcutaneous\" }\n[[hold]]\nwhere = \"x-\"\n",
                               file);
  EXPECT_EQ(scene.specimen.grid.cells(), (Index3{256, 256, 1}));
  // As floats it would be 1 GiB. Sanitizers keep what is given back for a while.
  EXPECT_LT(peak() - before, (test::is_sanitized ? std::int64_t{256} : std::int64_t{96}) << 20);
}

// Truth: how each voxel was written. Voxels of a named label are in the body, or a message counts them;
// smooth materials keep their volumes.
TEST(LabelsOracle, NamedVoxelsAreUsedOrSaid) {
  const TemporaryFolder folder;
  std::mt19937 random(41);
  std::int64_t unaccounted = 0;
  for (int file = 0; file < 500; ++file) {
    image_tests::NiftiFile nifti{.dim = {3, 4, 3, 5}, .datatype = 16, .bitpix = 32, .sform = 1};
    nifti.srow = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float scale = file % 3 == 0 ? 1000 : 1;
    const bool is_smooth = file % 2 == 1;
    const auto third = static_cast<std::int32_t>(3 * scale); // of a material of its own
    std::map<std::int32_t, double> named, found;
    std::int64_t said = 0;
    for (int voxel = 0; voxel < 60; ++voxel) {
      const int label = voxel < 3 ? voxel + 1 : int(random() % 6);
      float value = float(label) * scale;
      const auto kind = voxel < 3 ? 0 : random() % 8;
      if (kind < 3 && label > 0)
        for (unsigned ulp = 0; ulp < kind + 1; ++ulp)
          value = std::nextafter(value, random() % 2 == 0 ? INFINITY : 0);
      else if (kind == 3)
        value += 0.25F;
      nifti.data += image_tests::bytes_of(value, false);
      said += kind == 3 ? 1 : 0;
      if (kind != 3 && label >= 1 && label <= 3)
        ++named[static_cast<std::int32_t>(float(label) * scale)];
    }
    const std::string name = fmt::format("{}.nii", file);
    folder.write(name, nifti.bytes());
    std::string labels;
    for (int label = 1; label <= 3; ++label)
      labels += fmt::format("{}{} = {}", label > 1 ? ", " : "", static_cast<float>(label) * scale,
                            label == 3 ? "{ youngs_modulus = \"1 kPa\", poisson_ratio = 0.3 }"
                                       : "\"fat/subcutaneous\"");
    const Scene scene = parse_scene(
        fmt::format("[specimen]\nshape = \"image\"\nimage = \"{}\"\nlabels = {{ {} }}\n{}", name, labels,
                    is_smooth ? fmt::format("partial_volume = {{ smooth = \"{} mm\" }}\n{}",
                                            0.5 + 0.01 * static_cast<double>(random() % 100), hold)
                              : "[[hold]]\nwhere = \"z-\"\n"),
        folder.path() / "s.toml");
    const Specimen& body = scene.specimen;
    for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
      if (body.is_matter(cell))
        found[body.label[static_cast<std::size_t>(cell)]] += body.tissue_of(cell);
    const double of_third = named[third] - found[third];
    double missing = 0;
    for (const auto& [label, n] : named)
      missing += n - found[label];
    for (const LeftOutPiece& piece : scene.left_out)
      missing -= static_cast<double>(std::max<std::int64_t>(piece.cells, 0));
    const double error = std::max(std::abs(missing), is_smooth ? std::abs(of_third) : 0);
    EXPECT_LT(error, 1e-4) << file;
    unaccounted += error > 1e-4 ? 1 : 0;
    for (const std::string& warning : file_warnings(true))
      if (const std::size_t at = warning.find("no whole number"); at != std::string::npos)
        said -= std::stoll(warning.substr(warning.find(": ") + 2));
    unaccounted += std::abs(said);
  }
  EXPECT_EQ(unaccounted, 0);
  fmt::print("voxels_unaccounted {} of 500 files\n", unaccounted);
}

} // namespace
} // namespace maille
