

#include "conditions/region.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

namespace maille::reader {

std::optional<Region> Region::face(std::string_view name, int dimension) {
  const int n_axes = dimension > 0 ? dimension : 3;
  if (name.size() != 2 || name[0] < 'x' || name[0] >= 'x' + n_axes || (name[1] != '-' && name[1] != '+'))
    return std::nullopt;
  Region region(Kind::face);
  region.face_axis_ = name[0] - 'x';
  region.upper_ = name[1] == '+';
  return region;
}

Region Region::box(const Vec3& first, const Vec3& second) {
  Region region(Kind::box);
  for (std::size_t a = 0; a < 3; ++a) {
    region.low_[a] = std::min(first[a], second[a]);
    region.high_[a] = std::max(first[a], second[a]);
  }
  return region;
}

Region Region::numbered(std::vector<std::int64_t> nodes) {
  Region region(Kind::numbered);
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  region.numbers_ = std::move(nodes);
  return region;
}

bool Region::contains(const Specimen& body, const Index3& node) const {
  if (kind_ == Kind::numbered)
    return std::ranges::binary_search(numbers_, body.grid.node(node));
  if (kind_ == Kind::face) {
    const auto a = static_cast<std::size_t>(face_axis_);
    return node[a] == (upper_ ? body.grid.nodes()[a] - 1 : 0);
  }
  const Vec3 x = body.position(node);
  for (std::size_t a = 0; a < static_cast<std::size_t>(body.grid.dimension()); ++a) {
    // A corner that a person writes as 0.3 and the grid as 3 * 0.1 is the same corner.
    const double tolerance = 1e-6 * body.grid.spacing()[a];
    if (x[a] < low_[a] - tolerance || x[a] > high_[a] + tolerance)
      return false;
  }
  return true;
}

bool Region::contains_cell(const Specimen& body, std::int64_t cell) const {
  const Index3 at = body.grid.cell_at(cell);
  for (int corner = 0; corner < body.grid.corners_per_cell(); ++corner)
    if (!contains(body, body.grid.node_at(body.grid.corner(at, corner))))
      return false;
  return true;
}

std::vector<std::int64_t> Region::nodes(const Specimen& body) const {
  if (kind_ == Kind::numbered) {
    std::vector<std::int64_t> selected;
    std::ranges::copy_if(numbers_, std::back_inserter(selected),
                         [&](std::int64_t node) { return body.is_node(body.grid.node_at(node)); });
    return selected;
  }
  // Only the slab of a face, or the index range of a box, is looked at: scenes may have 10^8 nodes.
  Index3 first{0, 0, 0}, last = body.grid.nodes();
  for (std::size_t a = 0; a < static_cast<std::size_t>(body.grid.dimension()); ++a) {
    if (kind_ == Kind::face && face_axis_ == static_cast<int>(a)) {
      first[a] = upper_ ? body.grid.nodes()[a] - 1 : 0;
      last[a] = first[a] + 1;
    } else if (kind_ == Kind::box) {
      const double h = body.grid.spacing()[a];
      const double n = body.grid.nodes()[a];
      first[a] = static_cast<int>(std::clamp(std::floor((low_[a] - body.origin[a]) / h) - 1, 0.0, n));
      last[a] = static_cast<int>(std::clamp(std::ceil((high_[a] - body.origin[a]) / h) + 2, 0.0, n));
    }
  }
  std::vector<std::int64_t> selected;
  for (int k = first[2]; k < last[2]; ++k)
    for (int j = first[1]; j < last[1]; ++j)
      for (int i = first[0]; i < last[0]; ++i)
        if (const Index3 at{i, j, k}; contains(body, at) && body.is_node(at))
          selected.push_back(body.grid.node(at));
  return selected;
}

std::vector<FaceLoad> Region::faces(const Specimen& body) const {
  const Grid& grid = body.grid;
  std::vector<FaceLoad> selected;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (int side = 0; side < 2 * grid.dimension(); ++side) {
      const int axis = side / 2;
      const bool upper = side % 2;
      Index3 beyond = at;
      beyond[static_cast<std::size_t>(axis)] += upper ? 1 : -1;
      if (grid.has_cell(beyond) && body.is_matter(grid.cell(beyond)))
        continue;
      if (kind_ == Kind::face && (axis != face_axis_ || upper != upper_))
        continue;
      bool whole = true;
      for (int corner = 0; whole && corner < grid.corners_per_cell(); ++corner)
        if (((corner >> axis) & 1) == (upper ? 1 : 0))
          whole = contains(body, grid.node_at(grid.corner(at, corner)));
      if (whole)
        selected.push_back({cell, axis, upper, {}});
    }
  }
  return selected;
}

namespace {

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

} // namespace

std::vector<LabelRange> all_but_zero() {
  return {{-INFINITY, -1e-30F, 0}, {1e-30F, INFINITY, 0}};
}

void add_label(const LabelRange& range, const std::string& text, int line, const std::string& path,
               std::vector<LabelRange>& ranges, FaultList& faults) {
  for (const LabelRange& other : ranges)
    if (range.low <= other.high && other.low <= range.high)
      faults.add(line, path, "ranges of grey values that do not overlap", "\"" + text + "\"");
  ranges.push_back(range);
}

void check_labels_occur(const Image& image, const std::vector<LabelRange>& ranges,
                        const std::vector<NamedLabel>& names, const std::string& path, FaultList& faults) {
  std::vector<bool> occurs(ranges.size(), false);
  for (const float value : image.values)
    for (std::size_t i = 0; i < ranges.size(); ++i)
      if (double{value} >= ranges[i].low && double{value} <= ranges[i].high)
        occurs[i] = true;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!occurs[i])
      faults.add(names[i].line, path + "." + names[i].text,
                 "a grey value that occurs in the image, which has " + values_in_words(image),
                 "\"" + names[i].text + "\", which no voxel has");
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

bool has_matter(const Specimen& body, const std::string& path, int line, FaultList& faults) {
  if (body.n_matter_cells() > 0)
    return true;
  faults.add(line, path, "a grey value that occurs in the image", "no voxel with any of them");
  return false;
}

} // namespace maille::reader
