#include "conditions/region.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
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

/// Bounds of a box in another frame.
std::pair<Vec3, Vec3> bounds_in(const Placement& placement, const Vec3& first, const Vec3& last) {
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 x = point_in_world(placement, {(corner & 1 ? last : first)[0], (corner & 2 ? last : first)[1],
                                              (corner & 4 ? last : first)[2]});
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], x[a]);
      high[a] = std::max(high[a], x[a]);
    }
  }
  return {low, high};
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

double place_tolerance(const Specimen& body) {
  constexpr double of_a_spacing = 1e-4;
  const Vec3& spacing = body.grid.spacing();
  return of_a_spacing * *std::min_element(spacing.begin(), spacing.begin() + body.grid.dimension());
}

template<class IsIn>
bool Region::join(IsIn&& is_in) const {
  if (kind_ == Kind::outside)
    return !is_in(parts_.front());
  return kind_ == Kind::any ? std::ranges::any_of(parts_, is_in) : std::ranges::all_of(parts_, is_in);
}

bool Region::contains(const Specimen& body, const Index3& node) const {
  const double tolerance = place_tolerance(body);
  const auto is_between = [&](const Vec3& x, int n_axes) {
    for (std::size_t a = 0; a < static_cast<std::size_t>(n_axes); ++a)
      if (x[a] < low_[a] - tolerance || x[a] > high_[a] + tolerance)
        return false;
    return true;
  };
  switch (kind_) {
  case Kind::numbered:
    return std::ranges::binary_search(numbers_, body.grid.node(node));
  case Kind::face: {
    const auto a = static_cast<std::size_t>(face_axis_);
    return node[a] == (upper_ ? body.grid.nodes()[a] - 1 : 0);
  }
  case Kind::box:
    return is_between(body.position(node), body.grid.dimension());
  case Kind::placed_box:
    return is_between(point_in_world(placement_, body.position(node)), 3);
  case Kind::sphere: {
    const Vec3 x = body.position(node);
    return std::hypot(x[0] - centre_[0], x[1] - centre_[1], x[2] - centre_[2]) <= radius_ + tolerance;
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

namespace {

/// The last cell before void of a row of decreasing tissue fractions from `cell` along `axis`; `cell` itself
/// if the row does not decrease to void.
std::int64_t outermost(const Specimen& body, std::int64_t cell, int axis, bool upper) {
  Index3 at = body.grid.cell_at(cell);
  for (std::int64_t last = cell;; last = body.grid.cell(at)) {
    at[axis] += upper ? 1 : -1;
    if (!body.grid.has_cell(at) || !body.is_matter(body.grid.cell(at)))
      return last;
    if (body.tissue.empty() || body.tissue_of(body.grid.cell(at)) > body.tissue_of(last) ||
        body.tissue_of(body.grid.cell(at)) == 1)
      return cell;
  }
}

} // namespace

bool Region::contains_face(const Specimen& body, std::int64_t cell, int axis, bool upper) const {
  if (!parts_.empty())
    return join([&](const Region& part) { return part.contains_face(body, cell, axis, upper); });
  return has_face(body, body.tissue.empty() ? cell : outermost(body, cell, axis, upper), axis, upper);
}

bool Region::has_face(const Specimen& body, std::int64_t cell, int axis, bool upper) const {
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

bool Region::shares_nodes() const {
  return cells_ || kind_ == Kind::box || kind_ == Kind::placed_box || kind_ == Kind::sphere ||
         std::ranges::any_of(parts_, &Region::shares_nodes);
}

/// Tests a point slightly inside the cell; a box with a single plane of nodes has no inside across it.
bool Region::contains_corner(const Specimen& body, const Index3& node, std::int64_t cell) const {
  constexpr double inwards = 1e-3; // of a spacing
  if (!parts_.empty())
    return join([&](const Region& part) { return part.contains_corner(body, node, cell); });
  if ((cells_ && !std::ranges::binary_search(*cells_, cell)) || !contains(body, node))
    return false;
  const Grid& grid = body.grid;
  const Index3 at = grid.cell_at(cell);
  Vec3 x = body.position(node), low = body.position({0, 0, 0}), high = body.position(grid.cells());
  for (int a = 0; a < grid.dimension(); ++a)
    x[a] += (node[a] == at[a] ? inwards : -inwards) * grid.spacing()[a];
  if (kind_ == Kind::sphere)
    return std::hypot(x[0] - centre_[0], x[1] - centre_[1], x[2] - centre_[2]) < radius_;
  if (kind_ != Kind::box && kind_ != Kind::placed_box)
    return true;
  std::tie(low, high) = bounds_in(placement_, low, high);
  x = point_in_world(placement_, x);
  const double flat = 2 * place_tolerance(body);
  for (std::size_t a = 0; a < 3; ++a)
    if (std::min(high[a], high_[a]) - std::max(low[a], low_[a]) > flat &&
        (x[a] < low_[a] || x[a] >= high_[a]))
      return false;
  return true;
}

void Region::share_nodes(const Specimen& body, const std::vector<std::int64_t>& among,
                         std::vector<std::int64_t>& nodes, std::vector<std::int64_t>& cells) const {
  if (!shares_nodes())
    return;
  std::vector<std::int64_t> shared, bearing;
  for (const std::int64_t node : among)
    body.for_each_cell_at(body.grid.node_at(node), [&](std::int64_t cell) {
      if (contains_corner(body, body.grid.node_at(node), cell)) {
        shared.push_back(node);
        bearing.push_back(cell);
      }
    });
  if (shared.empty())
    return;
  sort_uniquely(shared);
  sort_uniquely(bearing);
  nodes = std::move(shared);
  cells = std::move(bearing);
}

std::vector<std::int64_t> Region::nodes(const Specimen& body) const {
  if (kind_ == Kind::numbered) {
    std::vector<std::int64_t> selected;
    std::ranges::copy_if(numbers_, std::back_inserter(selected),
                         [&](std::int64_t node) { return body.is_node(body.grid.node_at(node)); });
    return selected;
  }
  // Visits only the slab of a face, or the index range of a box: scenes may have 10^8 nodes.
  Index3 first{0, 0, 0}, last = body.grid.nodes();
  for (int a = 0; a < body.grid.dimension(); ++a) {
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
      beyond[axis] += upper ? 1 : -1;
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
  auto [low, high] = bounds_in(body.placement, body.position({0, 0, 0}), body.position(last));
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

/// The materials of the voxels of a row of cells, row by row.
class VoxelRows {
public:
  VoxelRows(std::size_t width, const std::vector<LabelRange>& ranges) : width_(width) {
    for (const LabelRange& range : ranges)
      n_materials_ = std::max(n_materials_, std::size_t{range.material} + 1);
    count_.resize(no_material + std::size_t{1});
  }
  /// Rows of other cells.
  void clear() { materials_.clear(); }
  void append(std::size_t n, std::uint8_t material) { materials_.resize(materials_.size() + n, material); }
  const std::vector<std::uint8_t>& materials() const { return materials_; }
  /// Call after all rows are added.
  void compare() {
    differs_.assign(width_, 0);
    for (std::size_t row = width_; row < materials_.size(); row += width_)
      for (std::size_t i = 0; i < width_; ++i)
        differs_[i] |= static_cast<std::uint8_t>(materials_[row + i] ^ materials_[i]);
  }
  /// The most frequent material of voxels `from` to before `to` over all rows, the first among equals; none
  /// if less than half of `voxels` is matter.
  std::uint8_t most_of(std::size_t from, std::size_t to, int voxels) {
    const std::uint8_t first = materials_[from];
    int different = 0;
    for (std::size_t i = from; i < to; ++i)
      different |= differs_[i] | (materials_[i] ^ first);
    if (different == 0) {
      const auto n = static_cast<int>(materials_.size() / width_ * (to - from));
      return 2 * n >= voxels ? first : no_material;
    }
    const auto begin = count_.begin(), end = begin + static_cast<std::ptrdiff_t>(n_materials_);
    std::fill(begin, end, 0);
    for (std::size_t row = 0; row < materials_.size(); row += width_)
      for (std::size_t i = row + from; i < row + to; ++i)
        ++count_[materials_[i]];
    return 2 * std::accumulate(begin, end, 0) >= voxels
               ? static_cast<std::uint8_t>(std::max_element(begin, end) - begin)
               : no_material;
  }

private:
  std::size_t width_, n_materials_ = 0;
  std::vector<std::uint8_t> materials_, differs_; ///< non-zero: differs from the first row
  std::vector<int> count_;                        ///< by material
};

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

void check_labels_occur(const LabelCensus& census, const std::vector<NamedLabel>& names,
                        const std::string& path, FaultList& faults) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (census.voxels(i) == 0)
      faults.add(names[i].line, path + "." + names[i].text,
                 "a grey value that occurs in the image, which has " + census.in_words(),
                 "\"" + names[i].text + "\", which no voxel has");
}

void fill_cells(const LayeredImage& image, const Index3& coarsen, const std::vector<LabelRange>& ranges,
                LabelCensus& census, Specimen& body) {
  const ImageInfo& info = image.info();
  Index3 cells{};
  Vec3 spacing{};
  for (std::size_t a = 0; a < 3; ++a) {
    cells[a] = (info.size[a] + coarsen[a] - 1) / coarsen[a];
    spacing[a] = info.spacing[a] * coarsen[a];
  }
  const Grid grid(info.size[2] == 1 ? 2 : 3, cells, spacing);
  LayerWindow layers = image.open(coarsen[2]);
  std::vector<std::uint8_t> found; // allocated only as the file fills it
  const auto width = static_cast<std::size_t>(info.size[0]);
  VoxelRows rows(width, ranges);
  for (int cell_k = 0; cell_k < cells[2]; ++cell_k) {
    layers.move_to(cell_k * coarsen[2], (cell_k + 1) * coarsen[2]);
    if (cell_k == 0)
      found.reserve(grid.n_cells());
    for (int cell_j = 0; cell_j < cells[1]; ++cell_j) {
      const VoxelBlock block({0, cell_j, cell_k}, coarsen, 0, info.size);
      rows.clear();
      for (int k = block.low[2]; k < block.high[2]; ++k)
        for (int j = block.low[1]; j < block.high[1]; ++j)
          for_each_run(layers.layer(k).subspan(static_cast<std::size_t>(j) * width, width),
                       [&](float value, std::size_t n) {
                         census.add(value, n);
                         rows.append(n, material_of(value, ranges));
                       });
      if (coarsen == Index3{1, 1, 1}) {
        found.insert(found.end(), rows.materials().begin(), rows.materials().end());
        continue;
      }
      rows.compare();
      for (std::size_t i = 0, n = static_cast<std::size_t>(coarsen[0]); i < width; i += n)
        found.push_back(rows.most_of(i, std::min(i + n, width), coarsen[0] * coarsen[1] * coarsen[2]));
    }
  }
  body.grid = grid;
  body.placement = placement_of(info);
  body.material_id = std::move(found);
}

bool has_matter(const Specimen& body, const std::string& path, int line, FaultList& faults) {
  if (body.n_matter_cells() > 0)
    return true;
  faults.add(line, path, "a grey value that occurs in the image", "no voxel with any of them");
  return false;
}

} // namespace maille::reader
