

#include "conditions/region.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

Region Region::placed_box(const Vec3& first, const Vec3& second, const Placement& placement) {
  Region region = box(first, second);
  region.kind_ = Kind::placed_box;
  region.placement_ = placement;
  return region;
}

Region Region::sphere(const Vec3& centre, double radius) {
  Region region(Kind::sphere);
  region.centre_ = centre;
  region.radius_ = radius;
  return region;
}

namespace {

void sort_uniquely(std::vector<std::int64_t>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

} // namespace

Region Region::numbered(std::vector<std::int64_t> nodes) {
  Region region(Kind::numbered);
  sort_uniquely(nodes);
  region.numbers_ = std::move(nodes);
  return region;
}

Region Region::numbered(std::vector<std::int64_t> nodes, std::vector<std::int64_t> cells) {
  Region region = numbered(std::move(nodes));
  sort_uniquely(cells);
  region.cells_ = std::move(cells);
  return region;
}

Region Region::of_cells(const Grid& grid, std::vector<std::int64_t> cells) {
  std::vector<std::int64_t> nodes;
  for (const std::int64_t cell : cells)
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner)
      nodes.push_back(grid.corner(grid.cell_at(cell), corner));
  return numbered(std::move(nodes), std::move(cells));
}

Region Region::joined(Kind kind, std::vector<Region> parts) {
  Region region(kind);
  region.parts_ = std::move(parts);
  return region;
}

Region Region::any(std::vector<Region> parts) {
  return joined(Kind::any, std::move(parts));
}

Region Region::all(std::vector<Region> parts) {
  return joined(Kind::all, std::move(parts));
}

Region Region::outside(Region part) {
  return joined(Kind::outside, {std::move(part)});
}

template<class IsIn>
bool Region::join(IsIn&& is_in) const {
  if (kind_ == Kind::outside)
    return !is_in(parts_.front());
  return kind_ == Kind::any ? std::ranges::any_of(parts_, is_in) : std::ranges::all_of(parts_, is_in);
}

bool Region::contains(const Specimen& body, const Index3& node) const {
  // A corner that a person writes as 0.3 and the grid as 3 * 0.1 is the same corner.
  constexpr double rounding = 1e-6;
  const auto is_between = [&](const Vec3& x, int n_axes, const auto& tolerance) {
    for (std::size_t a = 0; a < static_cast<std::size_t>(n_axes); ++a)
      if (x[a] < low_[a] - tolerance(a) || x[a] > high_[a] + tolerance(a))
        return false;
    return true;
  };
  const Vec3& spacing = body.grid.spacing();
  const double smallest = *std::min_element(spacing.begin(), spacing.begin() + body.grid.dimension());
  switch (kind_) {
  case Kind::numbered:
    return std::ranges::binary_search(numbers_, body.grid.node(node));
  case Kind::face: {
    const auto a = static_cast<std::size_t>(face_axis_);
    return node[a] == (upper_ ? body.grid.nodes()[a] - 1 : 0);
  }
  case Kind::box:
    return is_between(body.position(node), body.grid.dimension(),
                      [&](std::size_t a) { return rounding * spacing[a]; });
  case Kind::placed_box:
    return is_between(point_in_world(placement_, body.position(node)), 3,
                      [&](std::size_t) { return rounding * smallest; });
  case Kind::sphere: {
    const Vec3 x = body.position(node);
    return std::hypot(x[0] - centre_[0], x[1] - centre_[1], x[2] - centre_[2]) <=
           radius_ + rounding * smallest;
  }
  default:
    return join([&](const Region& part) { return part.contains(body, node); });
  }
}

bool Region::contains_cell(const Specimen& body, std::int64_t cell) const {
  if (!parts_.empty())
    return join([&](const Region& part) { return part.contains_cell(body, cell); });
  if (cells_ && !std::ranges::binary_search(*cells_, cell))
    return false;
  const Index3 at = body.grid.cell_at(cell);
  for (int corner = 0; corner < body.grid.corners_per_cell(); ++corner)
    if (!contains(body, body.grid.node_at(body.grid.corner(at, corner))))
      return false;
  return true;
}

bool Region::contains_face(const Specimen& body, std::int64_t cell, int axis, bool upper) const {
  if (!parts_.empty())
    return join([&](const Region& part) { return part.contains_face(body, cell, axis, upper); });
  if (kind_ == Kind::face && (axis != face_axis_ || upper != upper_))
    return false;
  if (cells_ && !std::ranges::binary_search(*cells_, cell))
    return false;
  const Index3 at = body.grid.cell_at(cell);
  for (int corner = 0; corner < body.grid.corners_per_cell(); ++corner)
    if (((corner >> axis) & 1) == (upper ? 1 : 0) &&
        !contains(body, body.grid.node_at(body.grid.corner(at, corner))))
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
    } else if (kind_ == Kind::box || kind_ == Kind::sphere) {
      const double h = body.grid.spacing()[a];
      const double n = body.grid.nodes()[a];
      const double low = kind_ == Kind::box ? low_[a] : centre_[a] - radius_;
      const double high = kind_ == Kind::box ? high_[a] : centre_[a] + radius_;
      first[a] = static_cast<int>(std::clamp(std::floor((low - body.origin[a]) / h) - 1, 0.0, n));
      last[a] = static_cast<int>(std::clamp(std::ceil((high - body.origin[a]) / h) + 2, 0.0, n));
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
  std::vector<FaceLoad> selected;
  for (const auto& [face, part] : weighted_faces(body))
    selected.push_back(face);
  return selected;
}

std::vector<std::pair<FaceLoad, double>> Region::weighted_faces(const Specimen& body) const {
  const Grid& grid = body.grid;
  std::vector<std::pair<FaceLoad, double>> selected;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (int side = 0; side < 2 * grid.dimension(); ++side) {
      const int axis = side / 2;
      const bool upper = side % 2;
      Index3 beyond = at;
      beyond[static_cast<std::size_t>(axis)] += upper ? 1 : -1;
      const bool is_inside = grid.has_cell(beyond) && body.is_matter(grid.cell(beyond));
      if (is_inside && body.tissue.empty())
        continue;
      const double part = body.tissue_of(cell) - (is_inside ? body.tissue_of(grid.cell(beyond)) : 0);
      if (part > 0 && contains_face(body, cell, axis, upper))
        selected.push_back({{cell, axis, upper, {}}, part});
    }
  }
  return selected;
}

std::string reach_in_words(const Specimen& body) {
  const auto words = [](const Vec3& low, const Vec3& high, int n_axes) {
    std::vector<std::string> ranges;
    for (std::size_t a = 0; a < static_cast<std::size_t>(n_axes); ++a)
      ranges.push_back(fmt::format("{} {:.5g} to {:.5g}", "xyz"[a], 1e3 * low[a], 1e3 * high[a]));
    return fmt::format("{} mm", fmt::join(ranges, ", "));
  };
  const Index3 last{body.grid.nodes()[0] - 1, body.grid.nodes()[1] - 1, body.grid.nodes()[2] - 1};
  std::string text =
      "the body reaches from " + words(body.position({0, 0, 0}), body.position(last), body.grid.dimension());
  if (body.placement.is_identity())
    return text;
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  for (int corner = 0; corner < 8; ++corner) {
    const Index3 at{corner & 1 ? last[0] : 0, corner & 2 ? last[1] : 0, corner & 4 ? last[2] : 0};
    const Vec3 x = point_in_world(body.placement, body.position(at));
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], x[a]);
      high[a] = std::max(high[a], x[a]);
    }
  }
  text += " in its grid; in the world " + words(low, high, 3);
  if (body.placement.world == WorldAxes::unknown)
    return text;
  std::swap(low[0], high[0]);
  std::swap(low[1], high[1]);
  for (std::size_t a = 0; a < 2; ++a) {
    low[a] = -low[a];
    high[a] = -high[a];
  }
  const bool is_ras = body.placement.world == WorldAxes::ras;
  return text + (is_ras ? " (RAS); in LPS " : " (LPS); in RAS ") + words(low, high, 3);
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

} // namespace

Placement placement_of(const ImageInfo& info) {
  Placement placement;
  placement.direction = info.direction;
  placement.world = info.world;
  for (std::size_t r = 0; r < 3; ++r) {
    placement.origin[r] = info.origin[r];
    for (std::size_t a = 0; a < 3; ++a)
      placement.origin[r] -= info.direction[r][a] * info.spacing[a] / 2;
  }
  return placement;
}

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
