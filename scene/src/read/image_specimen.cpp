#include "conditions/region.hpp"
#include "maille/images/image.hpp"
#include "maille/scene/read_scene.hpp"
#include "read/reader.hpp"
#include "voxels/label_cells.hpp"
#include "voxels/partial_volume.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace maille::reader {

namespace {

/// Voxels above `threshold`; without it, all non-zero voxels.
std::vector<LabelRange> read_threshold(TableReader& table) {
  if (!table.has("threshold"))
    return all_but_zero();
  const auto threshold = table.number("threshold");
  if (!threshold)
    return {};
  // Grey values are float32: the range starts at the next larger number.
  return {{std::nextafter(static_cast<float>(*threshold), INFINITY), INFINITY, 0}};
}

/// Named segments of the image; nothing if the header is unreadable, which the image reader reports.
std::optional<std::vector<NamedSegment>> segments_of(TableReader& table) {
  const toml::node* image = table.find("image");
  const auto name = image ? image->value<std::string>() : std::nullopt;
  if (!name)
    return std::vector<NamedSegment>{};
  try {
    const NamedFile file = named_file(*name, std::filesystem::path(table.faults().file()).parent_path());
    if (file.file.empty())
      return std::nullopt;
    read_image_info(file.file);
    return named_segments(file.file);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// A grey value, a range of them, or the name of a segment.
std::optional<LabelRange> label_or_name(std::string_view key, const std::vector<NamedSegment>& segments) {
  const auto named = std::ranges::find(segments, key, &NamedSegment::name);
  if (named == segments.end())
    return parse_label(key);
  const auto value = static_cast<float>(named->label);
  return LabelRange{value, value, 0};
}

/// `labels 1 and 2` for a name of several segments; empty if the name is unique.
std::string labels_of_one_name(std::string_view name, const std::vector<NamedSegment>& segments) {
  std::set<std::int32_t> labels;
  for (const NamedSegment& segment : segments)
    if (segment.name == name)
      labels.insert(segment.label);
  return labels.size() < 2 ? "" : fmt::format("labels {}", fmt::join(labels, " and "));
}

/// True if labels are readable; else one fault: segments in several layers, or labels that float32 cannot
/// represent.
bool are_labels_readable(TableReader& table, const std::vector<NamedSegment>& segments) {
  if (std::ranges::any_of(segments, [](const NamedSegment& segment) { return segment.layer > 0; })) {
    table.fault("image", "segments of one layer (in 3D Slicer: Segmentations, Collapse labelmap layers)",
                "segments that overlap, in several layers");
    for (const char* key : {"labels", "material", "threshold"})
      table.find(key);
    return false;
  }
  const toml::node* node = table.has("labels") ? table.find("labels") : nullptr;
  const toml::table* section = node ? node->as_table() : nullptr;
  std::vector<std::string> too_large;
  if (section)
    for (const auto& [key, value] : *section) {
      std::int64_t label = 0;
      const char *const from = key.str().data(), *const to = from + key.str().size();
      const auto [end, error] = std::from_chars(from, to, label);
      if (error == std::errc{} && end == to && !is_label(label) &&
          (std::abs(static_cast<double>(label)) > 9e18 ||
           static_cast<std::int64_t>(static_cast<float>(label)) != label))
        too_large.emplace_back(key.str());
    }
  if (!too_large.empty())
    table.fault("labels", wanted_label() + ": renumber the image's",
                fmt::format("{}", fmt::join(too_large, ", ")));
  return too_large.empty();
}

std::string wanted_labels(const std::vector<NamedSegment>& segments) {
  std::string wanted = "a grey value such as 17, or a range such as \"1150..4000\"";
  for (std::size_t i = 0; i < segments.size() && i < 10; ++i)
    wanted += (i == 0 ? ", or a segment: " : ", ") + segments[i].name;
  return wanted + (segments.size() > 10 ? ", ..." : segments.empty() ? " (names: of .seg.nrrd)" : "");
}

/// `labels = { 17 = "muscle/soleus", "1150..4000" = "bone/..." }`; or `material`, if required, for every
/// voxel above `threshold`, or every non-zero voxel.
std::vector<LabelRange> read_labels(TableReader& table, bool has_material,
                                    const std::vector<NamedSegment>& segments, bool has_image,
                                    MaterialTable& materials) {
  std::vector<LabelRange> ranges;
  if (!table.has("labels") && (table.has("material") || !has_material)) {
    const std::size_t before = table.faults().size();
    read_material(table, has_material, materials);
    ranges = read_threshold(table);
    return table.faults().size() == before ? ranges : std::vector<LabelRange>{};
  }
  const std::size_t faults_before = table.faults().size();
  table.require("labels");
  const toml::table* section = table.subtable("labels");
  if (!section)
    return {};
  const std::string path = table.path_of("labels");
  std::map<int, std::string> unknown; // by line: one fault per cause
  for (const auto& [key, node] : *section) {
    const auto range = label_or_name(key.str(), segments);
    if (const std::string several = labels_of_one_name(key.str(), segments); !several.empty())
      table.faults().add(line_of(node), path, "a name of one segment, or its label",
                         "\"" + std::string(key.str()) + "\", the name of " + several);
    if (!range) {
      std::string& names = unknown[line_of(node)];
      names += (names.empty() ? "\"" : ", \"") + std::string(key.str()) + "\"";
    }
    const auto material = materials.add(node, path + "." + std::string(key.str()), table.faults());
    if (!range || !material)
      continue;
    add_label({range->low, range->high, *material}, std::string(key.str()), line_of(node), path, ranges,
              table.faults());
  }
  for (const auto& [line, names] : unknown)
    if (has_image)
      table.faults().add(line, path, wanted_labels(segments), names);
  if (ranges.empty() && unknown.empty() && table.faults().size() == faults_before)
    table.fault("labels", "at least one grey value", "an empty table");
  return ranges;
}

/// The keys of `labels`, in the order of the ranges. @pre all are valid
std::vector<NamedLabel> names_of_labels(TableReader& table) {
  std::vector<NamedLabel> names;
  for (const auto& [key, node] : *table.subtable("labels"))
    names.push_back({std::string(key.str()), line_of(node)});
  return names;
}

std::optional<Index3> read_coarsen(TableReader& table) {
  const toml::node* node = table.find("coarsen");
  if (!node)
    return Index3{1, 1, 1};
  const std::vector<int> n = whole_numbers(*node, 1, 1000);
  if (n.size() == (node->is_array() ? 3 : 1))
    return Index3{n.front(), n[n.size() / 2], n.back()};
  table.fault("coarsen", "a whole number of voxels >= 1, or three");
  return std::nullopt;
}

bool cells_fit(const ImageInfo& info, const Index3& coarsen, const std::string& path, int line,
               FaultList& faults) {
  Index3 cells{};
  for (std::size_t a = 0; a < 3; ++a)
    cells[a] = (info.size[a] + coarsen[a] - 1) / coarsen[a];
  return fits_into_memory(cells, 3, path, line, faults);
}

/// A label image whose body fits into memory; nothing and a fault if the file is no label image.
/// @throws InputError
std::optional<LayeredImage> labels_of(const std::filesystem::path& file, const Index3& coarsen,
                                      const std::string& path, int line, FaultList& faults) {
  LayeredImage image(file);
  if (const int n = image.info().components; n != 1)
    faults.add(line, path, "an image of labels: one value a voxel", fmt::format("{} values a voxel", n));
  else if (cells_fit(image.info(), coarsen, path, line, faults))
    return image;
  return std::nullopt;
}

/// Compares the voxels of each label with its cells: a label without a cell is a fault, a loss of more than a
/// tenth a warning.
void account_for(const LabelCensus& census, const std::vector<LabelRange>& ranges,
                 const std::vector<NamedLabel>& names, const LabelCells& cells, const std::string& path,
                 const char* by, FaultList& faults, Scene& scene) {
  std::vector<std::int64_t> used(ranges.size(), 0), n_cells = used;
  cells.for_each_cell([&](std::int64_t cell, const std::vector<std::size_t>& own) {
    const float label = cells.labels()[cell];
    for (std::size_t i = 0; i < ranges.size(); ++i)
      if (label >= ranges[i].low && label <= ranges[i].high) {
        used[i] += std::ssize(own);
        ++n_cells[i];
      }
  });
  constexpr double said_at = 0.1; // fraction of a label; smaller losses at borders are normal with `coarsen`
  std::string lost;
  bool is_much = false;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const std::int64_t all = census.voxels(i), gone = all - used[i];
    const double share = static_cast<double>(gone) / static_cast<double>(std::max<std::int64_t>(all, 1));
    is_much = is_much || share > said_at;
    if (all > 0 && n_cells[i] == 0)
      faults.add(names[i].line, path + "." + names[i].text,
                 fmt::format("a label that most voxels of some cell have: a smaller `{}`", by),
                 fmt::format("{} voxels, all of them in cells of other labels or of none", all));
    else if (gone > 0)
      lost += fmt::format("{}{} of {} of label {} ({:.2g} %)", lost.empty() ? "" : ", ", gone, all,
                          names[i].text, 100 * share);
  }
  if (!lost.empty())
    scene.left_out.push_back(
        {is_much ? 0 : -1, fmt::format("{}: voxels in cells of other labels or of none: {}", by, lost)});
}

/// Reports the volume that smooth labels lose in cells below `least` and cannot redistribute.
void account_for_volume(const LabelCensus& census, std::size_t n_ranges, const Index3& coarsen,
                        Scene& scene) {
  constexpr double said_at = 1e-3, warned_of_at = 0.05; // of the labels
  double labels = 0, tissue = 0;                        // voxels
  for (std::size_t i = 0; i < n_ranges; ++i)
    labels += static_cast<double>(census.voxels(i));
  for (const float part : scene.specimen.tissue)
    tissue += double{part} * coarsen[0] * coarsen[1] * coarsen[2];
  if (const double share = 1 - tissue / labels; std::abs(share) > said_at)
    scene.left_out.push_back(
        {std::abs(share) > warned_of_at ? 0 : -1,
         fmt::format("partial_volume.smooth: {:.2g} % of the labels' volume lies in cells below `least`",
                     100 * share)});
}

void read_tensors(const FibreRequest& fibre, const LabelCells& labels, TableReader& table, Specimen& body) {
  const std::string path = table.path_of("fibre");
  const auto file = resolve_path(fibre.tensor_image, path, fibre.line, table.faults());
  if (!file)
    return;
  try {
    fibres_from_tensors(*file, fibre, labels, path, table.faults(), body);
  } catch (const InputError& error) {
    adopt(error, path, fibre.line, table.faults());
  }
}

} // namespace

bool read_image_specimen(TableReader& table, bool has_material, MaterialTable& materials, Scene& scene,
                         std::vector<float>* labels, const Image* given) {
  Specimen& body = scene.specimen;
  FaultList& faults = table.faults();
  const std::size_t faults_before = faults.size();
  const toml::node* image_node = given ? nullptr : table.require("image");
  const auto name = given ? std::optional<std::string>("") : table.text("image");
  const auto named = segments_of(table);
  const auto segments = named.value_or(std::vector<NamedSegment>{});
  const bool is_readable = are_labels_readable(table, segments);
  const auto ranges = is_readable ? read_labels(table, has_material, segments, named.has_value(), materials)
                                  : std::vector<LabelRange>{};
  const auto coarsen = read_coarsen(table);
  const auto fibre = read_fibre(table);
  const auto partial = read_partial_volume(table, coarsen.value_or(Index3{2, 2, 2}));
  if (!name || !coarsen || !fibre || !is_readable)
    return false;
  const int line = image_node ? line_of(*image_node) : 0;
  const std::string path = table.path_of("image");
  const auto file =
      given ? std::optional<std::filesystem::path>("") : resolve_path(*name, path, line, faults);
  if (!file)
    return false;
  try {
    auto image = given ? LayeredImage(*given) : labels_of(*file, *coarsen, path, line, faults);
    if (!image)
      return false;
    if (table.has("labels"))
      image->round_to(single_labels(ranges));
    // Outside the image is void, as in a larger image of the same body.
    // fill_partial_volume reports a width out of range.
    const bool is_smooth = partial && partial->from == PartialVolume::From::smooth && partial->width > 0 &&
                           partial->width <= widest_smooth * *std::ranges::min_element(image->info().spacing);
    const Index3 voids = is_smooth ? voids_around(image->info(), partial->width, *coarsen) : Index3{};
    const LayeredImage around = image->padded(voids);
    if (!cells_fit(around.info(), *coarsen, path, line, faults))
      return false;
    LabelCensus census(ranges);
    fill_cells(around, *coarsen, ranges, census, body);
    body.placement = placement_of(image->info());
    const bool is_segmented = table.has("labels");
    if (faults.size() == faults_before && is_segmented)
      check_labels_occur(census, names_of_labels(table), table.path_of("labels"), faults);
    if (faults.size() > faults_before)
      return false;
    body.image = file->string();
    if (partial)
      fill_partial_volume(*partial, around, ranges, *coarsen, table, body);
    const char* const key = is_segmented ? "labels" : "image";
    if (!has_matter(body, table.path_of(key), table.line_of_key(key), faults))
      return false;
    Index3 first = crop_to_matter(body);
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] -= voids[a] / (*coarsen)[a];
      body.origin[a] = first[a] * body.grid.spacing()[a];
    }
    if (!place_fibres(*fibre, body, faults))
      return false;
    if (is_smooth)
      account_for_volume(census, ranges.size(), *coarsen, scene);
    if (labels || is_segmented || !fibre->tensor_image.empty()) {
      const LabelCells cells(*image, ranges, first, *coarsen, body);
      if (is_segmented)
        body.label = cells.whole_labels();
      const bool is_coarse = *coarsen != Index3{1, 1, 1};
      if (is_segmented && (is_coarse || partial))
        account_for(census, ranges, names_of_labels(table), cells, table.path_of("labels"),
                    is_coarse ? "coarsen" : "partial_volume", faults, scene);
      if (!fibre->tensor_image.empty())
        read_tensors(*fibre, cells, table, body);
      if (labels)
        *labels = cells.labels();
    }
  } catch (const InputError& error) {
    adopt(error, path, line, faults);
  }
  return faults.size() == faults_before;
}

} // namespace maille::reader
