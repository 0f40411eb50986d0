#include "image/label_cells.hpp"
#include "maille/scene/image.hpp"
#include "read/reader.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace maille::reader {

namespace {

/// Voxels above `threshold`, or all that are not 0.
std::vector<LabelRange> read_threshold(TableReader& table) {
  if (!table.has("threshold"))
    return {{-INFINITY, -1e-30F, 0}, {1e-30F, INFINITY, 0}};
  const auto threshold = table.quantity("threshold", Dimension::dimensionless);
  if (!threshold)
    return {};
  // Grey values are float32: those above are the next one and what follows.
  return {{std::nextafter(static_cast<float>(*threshold), INFINITY), INFINITY, 0}};
}

/// `labels = { 17 = "muscle/soleus", "1150..4000" = "bone/..." }`, or `material`, if there must be one, for
/// every voxel above `threshold`, or that is not 0.
std::vector<LabelRange> read_labels(TableReader& table, bool has_material, MaterialTable& materials) {
  std::vector<LabelRange> ranges;
  if (!table.has("labels") && (table.has("material") || !has_material)) {
    const std::size_t before = table.faults().size();
    read_material(table, has_material, materials);
    ranges = read_threshold(table);
    return table.faults().size() == before ? ranges : std::vector<LabelRange>{};
  }
  const std::size_t faults_before = table.faults().size();
  table.require("labels", "a table from grey values to materials, e.g. { 17 = \"muscle/soleus\" }");
  const toml::table* section = table.subtable("labels");
  if (!section)
    return {};
  const std::string path = table.path_of("labels");
  for (const auto& [key, node] : *section) {
    const auto range = parse_label(key.str());
    if (!range)
      table.faults().add(line_of(node), path, "a grey value such as 17, or a range such as \"1150..4000\"",
                         "\"" + std::string(key.str()) + "\"");
    const auto material = materials.add(node, path + "." + std::string(key.str()), table.faults());
    if (!range || !material)
      continue;
    for (const LabelRange& other : ranges)
      if (range->low <= other.high && other.low <= range->high)
        table.faults().add(line_of(node), path, "ranges of grey values that do not overlap",
                           "\"" + std::string(key.str()) + "\"");
    ranges.push_back({range->low, range->high, *material});
  }
  if (ranges.empty() && table.faults().size() == faults_before)
    table.fault("labels", "at least one grey value", "an empty table");
  return ranges;
}

/// The grey values of an image but 0, shortly: each where they are few and whole, else from where to where.
std::string values_in_words(const Image& image) {
  constexpr std::size_t most = 40;
  std::set<float> values;
  for (const float value : image.values) {
    if (value != 0 && std::isfinite(value))
      values.insert(value);
    if (values.size() > most)
      break;
  }
  if (values.empty())
    return "nothing but 0";
  if (values.size() <= most)
    return fmt::format("{}", fmt::join(values, ", "));
  const auto [low, high] = std::ranges::minmax_element(image.values);
  return fmt::format("more than {} grey values from {} to {}", most, *low, *high);
}

/// A label that no voxel has is a slip: what it was meant for would be missing without a word.
void check_labels_occur(TableReader& table, const Image& image, const std::vector<LabelRange>& ranges) {
  const toml::table* section = table.subtable("labels");
  std::vector<bool> occurs(ranges.size(), false);
  for (const float value : image.values)
    for (std::size_t i = 0; i < ranges.size(); ++i)
      if (double{value} >= ranges[i].low && double{value} <= ranges[i].high)
        occurs[i] = true;
  std::size_t i = 0;
  for (const auto& [key, node] : *section) { // in the order of the ranges, all of which were good
    if (!occurs[i++])
      table.faults().add(line_of(node), table.path_of("labels") + "." + std::string(key.str()),
                         "a grey value that occurs in the image, which has " + values_in_words(image),
                         "\"" + std::string(key.str()) + "\", which no voxel has");
  }
}

std::optional<Index3> read_coarsen(TableReader& table) {
  const toml::node* node = table.find("coarsen");
  if (!node)
    return Index3{1, 1, 1};
  Index3 coarsen{};
  const auto* list = node->as_array();
  bool good = !list || list->size() == 3;
  for (std::size_t a = 0; good && a < 3; ++a) {
    const auto* number = (list ? list->get(a) : node)->as_integer();
    good = number && number->get() >= 1 && number->get() <= 1000;
    if (good)
      coarsen[a] = static_cast<int>(number->get());
  }
  if (good)
    return coarsen;
  table.fault("coarsen", "a whole number of voxels >= 1, or three", describe(*node));
  return std::nullopt;
}

/// The material that most voxels of a block hold; none where less than half of the block is matter.
std::uint8_t block_material(const Image& image, const Index3& first, const Index3& coarsen,
                            const std::vector<LabelRange>& ranges) {
  const Index3& size = image.info.size;
  if (coarsen == Index3{1, 1, 1}) {
    const std::int64_t voxel =
        first[0] + std::int64_t{size[0]} * (first[1] + std::int64_t{size[1]} * first[2]);
    return material_of(image.values[static_cast<std::size_t>(voxel)], ranges);
  }
  std::array<int, 256> count{};
  for (int k = first[2]; k < std::min(first[2] + coarsen[2], size[2]); ++k)
    for (int j = first[1]; j < std::min(first[1] + coarsen[1], size[1]); ++j)
      for (int i = first[0]; i < std::min(first[0] + coarsen[0], size[0]); ++i) {
        const std::int64_t v = i + std::int64_t{size[0]} * (j + std::int64_t{size[1]} * k);
        ++count[material_of(image.values[static_cast<std::size_t>(v)], ranges)];
      }
  const int voxels = coarsen[0] * coarsen[1] * coarsen[2];
  const auto most = std::max_element(count.begin(), count.end() - 1);
  int matter = 0;
  for (auto c = count.begin(); c != count.end() - 1; ++c)
    matter += *c;
  return 2 * matter >= voxels ? static_cast<std::uint8_t>(most - count.begin()) : no_material;
}

/// The object's frame has its origin at the outer corner of voxel 0 and its axes along the image's.
Placement placement_of(const ImageInfo& info) {
  Placement placement;
  placement.direction = info.direction;
  for (std::size_t r = 0; r < 3; ++r) {
    placement.origin[r] = info.origin[r];
    for (std::size_t a = 0; a < 3; ++a)
      placement.origin[r] -= info.direction[r][a] * info.spacing[a] / 2;
  }
  return placement;
}

void fill_cells(const Image& image, const Index3& coarsen, const std::vector<LabelRange>& ranges,
                Specimen& body) {
  Index3 cells{};
  Vec3 spacing{};
  for (std::size_t a = 0; a < 3; ++a) {
    cells[a] = (image.info.size[a] + coarsen[a] - 1) / coarsen[a];
    spacing[a] = image.info.spacing[a] * coarsen[a];
  }
  body.grid = Grid(image.info.size[2] == 1 ? 2 : 3, cells, spacing);
  body.placement = placement_of(image.info);
  body.material_id.resize(static_cast<std::size_t>(body.grid.n_cells()));
  for (std::size_t cell = 0; cell < body.material_id.size(); ++cell) {
    Index3 first = body.grid.cell_at(static_cast<std::int64_t>(cell));
    for (std::size_t a = 0; a < 3; ++a)
      first[a] *= coarsen[a];
    body.material_id[cell] = block_material(image, first, coarsen, ranges);
  }
}

/// The image's matter as cells of the specimen, before cropping.
bool read_cells(const std::filesystem::path& file, const Index3& coarsen,
                const std::vector<LabelRange>& ranges, const std::string& path, int line, FaultList& faults,
                Specimen& body, Image& image) {
  try {
    const ImageInfo info = read_image_info(file);
    if (info.components != 1) {
      faults.add(line, path, "an image of labels: one value a voxel",
                 fmt::format("{} values a voxel", info.components));
      return false;
    }
    Index3 cells{};
    for (std::size_t a = 0; a < 3; ++a)
      cells[a] = (info.size[a] + coarsen[a] - 1) / coarsen[a];
    if (!fits_into_memory(cells, 3, path, line, faults))
      return false;
    image = read_image(file);
    fill_cells(image, coarsen, ranges, body);
    return true;
  } catch (const InputError& error) {
    adopt(error, path, line, faults);
    return false;
  }
}

void read_tensors(const FibreRequest& fibre, const std::filesystem::path& folder, const LabelCells& labels,
                  TableReader& table, Specimen& body) {
  const std::string path = table.path_of("fibre");
  const auto file = resolve_path(fibre.tensor_image, folder, path, fibre.line, table.faults());
  if (!file)
    return;
  try {
    fibres_from_tensors(*file, fibre, labels, path, table.faults(), body);
  } catch (const InputError& error) {
    adopt(error, path, fibre.line, table.faults());
  }
}

} // namespace

bool read_image_specimen(TableReader& table, const std::filesystem::path& folder, bool has_material,
                         MaterialTable& materials, Specimen& body, std::vector<float>* labels) {
  const std::size_t faults_before = table.faults().size();
  const toml::node* image_node = table.require("image", "a file: .nii, .nii.gz, .mha, .mhd or .vti");
  const auto name = table.text("image");
  const auto ranges = read_labels(table, has_material, materials);
  const auto coarsen = read_coarsen(table);
  const auto fibre = read_fibre(table);
  if (!name || !coarsen || !fibre)
    return false;
  const int line = line_of(*image_node);
  const std::string path = table.path_of("image");
  const auto file = resolve_path(*name, folder, path, line, table.faults());
  Image image;
  if (!file || !read_cells(*file, *coarsen, ranges, path, line, table.faults(), body, image) ||
      table.faults().size() > faults_before)
    return false;
  const bool is_segmented = table.has("labels");
  if (is_segmented)
    check_labels_occur(table, image, ranges);
  if (table.faults().size() > faults_before)
    return false;
  if (body.n_matter_cells() == 0) {
    table.fault(table.has("labels") ? "labels" : "image", "a grey value that occurs in the image",
                "no voxel with any of them");
    return false;
  }
  const Index3 first = crop_to_matter(body);
  place_fibres(*fibre, body);
  if (labels || is_segmented || !fibre->tensor_image.empty()) {
    const LabelCells cells(image, ranges, first, *coarsen, body);
    if (is_segmented)
      body.label = cells.whole_labels();
    if (!fibre->tensor_image.empty())
      read_tensors(*fibre, folder, cells, table, body);
    if (labels)
      *labels = cells.labels();
  }
  return table.faults().size() == faults_before;
}

} // namespace maille::reader
