#include "elastic/masked/masked_rows.hpp"

#include <algorithm>

namespace maille::deform {

MaskedRows::MaskedRows(const Specimen& body) : rows_in_plane_(body.grid.nodes()[1]) {
  place_cells(body);
  place_nodes(body.grid);
  for (CellRun& run : runs_)
    for (int corner = 0; corner < 4; ++corner)
      run.node_slot[corner] = slot({run.first[0], run.first[1] + (corner & 1), run.first[2] + (corner >> 1)});
}

void MaskedRows::place_cells(const Specimen& body) {
  const Index3& cells = body.grid.cells();
  first_run_.push_back(0);
  for (int z = 0; z < cells[2]; ++z) {
    for (int y = 0; y < cells[1]; ++y) {
      const std::int64_t row = body.grid.cell({0, y, z});
      bool goes_on = false;
      for (int x = 0; x < cells[0]; x += block) {
        const int end = std::min(x + block, cells[0]);
        bool has_matter = false;
        for (int i = x; i < end; ++i)
          has_matter = has_matter || body.is_matter(row + i);
        if (has_matter && !goes_on)
          runs_.push_back({{x, y, z}, {}, n_cell_slots_, 0, 0});
        if (has_matter) {
          CellRun& run = runs_.back();
          ++run.blocks;
          n_cell_slots_ += block;
          // The last cell's farther corners are in the next block of nodes.
          run.node_blocks = run.blocks + (end == x + block && body.is_matter(row + end - 1) ? 1 : 0);
        }
        goes_on = has_matter;
      }
    }
    first_run_.push_back(static_cast<std::int32_t>(runs_.size()));
  }
}

void MaskedRows::place_nodes(const Grid& grid) {
  const Index3& nodes = grid.nodes();
  const auto blocks = static_cast<std::size_t>((nodes[0] + block - 1) / block);
  const auto rows = static_cast<std::size_t>(nodes[1]) * static_cast<std::size_t>(nodes[2]);
  std::vector<bool> is_kept(blocks * rows, false);
  for (const CellRun& run : runs_)
    for (int corner = 0; corner < 4; ++corner) {
      const auto row =
          static_cast<std::size_t>(run.first[1] + (corner & 1)) +
          static_cast<std::size_t>(nodes[1]) * static_cast<std::size_t>(run.first[2] + (corner >> 1));
      for (int b = 0; b < run.node_blocks; ++b)
        is_kept[row * blocks + static_cast<std::size_t>(run.first[0] / block + b)] = true;
    }
  first_row_.push_back(0);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t b = 0; b < blocks; ++b) {
      if (!is_kept[row * blocks + b])
        continue;
      if (b == 0 || !is_kept[row * blocks + b - 1])
        node_rows_.push_back({{static_cast<int>(b) * block, static_cast<int>(row) % nodes[1],
                               static_cast<int>(row) / nodes[1]},
                              n_slots_,
                              0});
      ++node_rows_.back().blocks;
      n_slots_ += block;
    }
    first_row_.push_back(static_cast<std::int32_t>(node_rows_.size()));
  }
}

std::span<const CellRun> MaskedRows::runs_of_layer(int z) const {
  const auto layer = static_cast<std::size_t>(z);
  return std::span(runs_).subspan(static_cast<std::size_t>(first_run_[layer]),
                                  static_cast<std::size_t>(first_run_[layer + 1] - first_run_[layer]));
}

std::int32_t MaskedRows::slot(const Index3& node) const {
  const auto row = static_cast<std::size_t>(node[1] + rows_in_plane_ * node[2]);
  auto i = static_cast<std::size_t>(first_row_[row + 1] - 1);
  while (node_rows_[i].first[0] > node[0])
    --i;
  return node_rows_[i].slot + node[0] - node_rows_[i].first[0];
}

} // namespace maille::deform
