#include "geometry/pieces.hpp"
#include "cell_values.hpp"
#include "maille/scene/matter_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace maille {

namespace {

/// Calls visit(run, other run) for pairs from two rows, including all pairs that share a face or a node.
template<class Visit>
void for_each_overlap(std::span<const BodyPieces::Run> one, std::span<const BodyPieces::Run> other,
                      const Visit& visit) {
  for (std::size_t i = 0, j = 0; i < one.size() && j < other.size();) {
    visit(one[i], other[j]);
    if (one[i].end < other[j].end)
      ++i;
    else
      ++j;
  }
}

} // namespace

BodyPieces::BodyPieces(const Specimen& body) : grid_(body.grid) {
  find_runs(body);
  join();
  number();
}

/// Finds runs; each starts as a separate piece.
void BodyPieces::find_runs(const Specimen& body) {
  const Index3& n = grid_.cells();
  const std::int64_t rows = std::int64_t{1} * n[1] * n[2];
  first_.reserve(static_cast<std::size_t>(rows) + 1);
  first_.push_back(0);
  for (std::int64_t row = 0; row < rows; ++row) {
    for_each_run_of_matter(body, row, [&](int begin, int end) {
      runs_.push_back({begin, end, static_cast<std::int32_t>(runs_.size())});
    });
    first_.push_back(runs_.size());
  }
}

/// Gives runs of one piece the same number: that of the first of them.
void BodyPieces::join() {
  const auto root = [&](std::int32_t run) {
    while (runs_[run].piece != run) {
      std::int32_t& piece = runs_[run].piece;
      piece = runs_[piece].piece;
      run = piece;
    }
    return run;
  };
  const auto join_rows = [&](std::int64_t one, std::int64_t other) {
    for_each_overlap(runs_of_row(one), runs_of_row(other), [&](const Run& a, const Run& b) {
      if (std::max(a.begin, b.begin) >= std::min(a.end, b.end))
        return;
      const std::int32_t p = root(static_cast<std::int32_t>(&a - runs_.data())),
                         q = root(static_cast<std::int32_t>(&b - runs_.data()));
      runs_[std::max(p, q)].piece = std::min(p, q);
    });
  };
  const int per_layer = grid_.cells()[1];
  for (std::int64_t row = 0; row < n_rows(); ++row) {
    if (row % per_layer > 0)
      join_rows(row - 1, row);
    if (row >= per_layer)
      join_rows(row - per_layer, row);
  }
  for (Run& run : runs_) // a number is that of an earlier run
    run.piece = runs_[run.piece].piece;
}

void BodyPieces::number() {
  const int per_layer = grid_.cells()[1];
  for (std::int64_t row = 0; row < n_rows(); ++row) {
    const int y = static_cast<int>(row % per_layer), z = static_cast<int>(row / per_layer);
    for (std::size_t i = first_[row]; i < first_[static_cast<std::size_t>(row) + 1]; ++i) {
      Run& run = runs_[i];
      if (run.piece == static_cast<std::int32_t>(i)) {
        run.piece = static_cast<std::int32_t>(pieces_.size());
        pieces_.push_back({0, grid_.cell({run.begin, y, z}), {run.begin, y, z}, {run.end, y, z}});
      } else
        run.piece = runs_[run.piece].piece;
      Piece& piece = pieces_[run.piece];
      piece.cells += run.end - run.begin;
      const Index3 lower{run.begin, y, z}, upper{run.end, y + 1, z + 1};
      for (std::size_t a = 0; a < 3; ++a) {
        piece.lower[a] = std::min(piece.lower[a], lower[a]);
        piece.upper[a] = std::max(piece.upper[a], upper[a]);
      }
    }
  }
}

/// Runs in one of the four rows of cells around a row of nodes.
std::span<const BodyPieces::Run> BodyPieces::runs_beside(const Index3& node, int side) const {
  const int y = node[1] - (side & 1), z = node[2] - (side >> 1);
  const Index3& n = grid_.cells();
  return y < 0 || y >= n[1] || z < 0 || z >= n[2] ? std::span<const Run>()
                                                  : runs_of_row(y + std::int64_t{1} * n[1] * z);
}

std::vector<std::int32_t> BodyPieces::at_node(const Index3& node) const {
  std::vector<std::int32_t> found;
  for (int side = 0; side < 4; ++side) {
    const std::span<const Run> runs = runs_beside(node, side);
    const auto run = std::ranges::lower_bound(runs, node[0], {}, &Run::end);
    if (run != runs.end() && run->begin <= node[0])
      found.push_back(run->piece);
  }
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

void BodyPieces::add_shared_nodes_of_row(int y, int z, std::vector<std::int64_t>& nodes) const {
  const std::size_t before = nodes.size();
  for (int one = 0; one < 4; ++one)
    for (int other = 0; other < one; ++other)
      for_each_overlap(
          runs_beside({0, y, z}, one), runs_beside({0, y, z}, other), [&](const Run& a, const Run& b) {
            for (int x = std::max(a.begin, b.begin); a.piece != b.piece && x <= std::min(a.end, b.end); ++x)
              nodes.push_back(grid_.node({x, y, z}));
          });
  std::sort(nodes.begin() + static_cast<std::ptrdiff_t>(before), nodes.end());
  nodes.erase(std::unique(nodes.begin() + static_cast<std::ptrdiff_t>(before), nodes.end()), nodes.end());
}

std::vector<std::int64_t> BodyPieces::shared_nodes() const {
  std::vector<std::int64_t> nodes;
  if (pieces_.size() > 1)
    for (int z = 0; z < grid_.nodes()[2]; ++z)
      for (int y = 0; y < grid_.nodes()[1]; ++y)
        add_shared_nodes_of_row(y, z, nodes);
  return nodes;
}

} // namespace maille

namespace maille::reader {

namespace {

std::string name_of(const Scene& scene, std::int32_t number, std::int64_t cells, std::int64_t first_cell) {
  const Vec3 x = scene.specimen.position(
      scene.specimen.grid.node_at(scene.specimen.grid.corner(scene.specimen.grid.cell_at(first_cell), 0)));
  return fmt::format("piece {}: {} cell{} of {} from ({:.4g}, {:.4g}, {:.4g}) m on", number + 1, cells,
                     cells == 1 ? "" : "s", scene.materials[scene.specimen.material(first_cell)].name, x[0],
                     x[1], x[2]);
}

} // namespace

std::int64_t leave_out_loose_pieces(Scene& scene, const std::vector<std::int64_t>& anchors) {
  Specimen& body = scene.specimen;
  if (body.material_id.empty()) // a full box is one piece
    return anchors.empty() ? 0 : body.grid.n_cells();
  const BodyPieces found(body);
  std::vector<bool> is_kept(found.pieces().size(), false);
  for (const std::int64_t node : anchors)
    for (const std::int32_t piece : found.at_node(body.grid.node_at(node)))
      is_kept[piece] = true;
  std::int64_t remaining = 0;
  for (std::size_t i = 0; i < is_kept.size(); ++i)
    if (const BodyPieces::Piece& piece = found.pieces()[i]; is_kept[i])
      remaining += piece.cells;
    else
      scene.left_out.push_back(
          {piece.cells, name_of(scene, static_cast<std::int32_t>(i), piece.cells, piece.first_cell)});
  for (std::int64_t row = 0; row < found.n_rows() && !scene.left_out.empty(); ++row)
    for (const BodyPieces::Run& run : found.runs_of_row(row)) {
      const std::int64_t first = row * body.grid.cells()[0] + run.begin;
      if (is_kept[run.piece])
        continue;
      std::fill_n(body.material_id.begin() + first, run.end - run.begin, no_material);
      if (!body.label.empty())
        std::fill_n(body.label.begin() + first, run.end - run.begin, 0);
    }
  return remaining;
}

Index3 crop_to_matter(Specimen& body) {
  const Grid grid = body.grid;
  const Index3& n = grid.cells();
  Index3 low = n, high{-1, -1, -1};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for_each_run_of_matter(body, j + std::int64_t{n[1]} * k, [&](int first, int end) {
        low = {std::min(low[0], first), std::min(low[1], j), std::min(low[2], k)};
        high = {std::max(high[0], end - 1), std::max(high[1], j), k};
      });
  Index3 size{};
  for (std::size_t a = 0; a < 3; ++a)
    size[a] = high[a] - low[a] + 1;
  if (size == n)
    return low;
  body.grid = Grid(grid.dimension(), size, grid.spacing());
  for_each_cell_array(body, [&]<class T>(std::vector<T>& values, const T&) {
    if (values.empty())
      return;
    auto kept = std::exchange(values, {});
    values.reserve(body.grid.n_cells());
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j) {
        const auto row = kept.begin() + grid.cell({low[0], j, k});
        values.insert(values.end(), row, row + size[0]);
      }
  });
  for (std::size_t a = 0; a < 3; ++a)
    body.origin[a] += low[a] * grid.spacing()[a];
  return low;
}

} // namespace maille::reader
