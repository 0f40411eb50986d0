#include "elastic/masked/masked_rows.hpp"

#include "maille/scene/matter_runs.hpp"

#include <utility>

namespace maille::deform {

MaskedRows::MaskedRows(const Specimen& body) : MaskedRows(body, {0, body.grid.cells()[2]}) {}

MaskedRows::MaskedRows(const Specimen& body, LayerRange layers)
    : layers_(layers), rows_in_plane_(body.grid.nodes()[1]) {
  place_cells(body);
  place_nodes(body.grid);
  for (CellRun& run : runs_)
    for (int corner = 0; corner < 4; ++corner)
      run.node_slot[corner] = slot({run.first[0], run.first[1] + (corner & 1), run.first[2] + (corner >> 1)});
}

namespace {

/// Longest gap of void cells inside a run. A gap of one has no void node, a gap of two has one in each of the
/// four rows.
constexpr int longest_gap = 2;

} // namespace

void MaskedRows::place_cells(const Specimen& body) {
  const Index3& cells = body.grid.cells();
  first_run_.push_back(0);
  for (int z = layers_.first; z < layers_.end; ++z) {
    for (int y = 0; y < cells[1]; ++y) {
      int end_before = -longest_gap - 1;
      for_each_run_of_matter(body, y + std::int64_t{1} * cells[1] * z, [&](int first, int end) {
        if (first - end_before > longest_gap)
          runs_.push_back({{first, y, z}, {}, 0, 0, false});
        runs_.back().cells = end - runs_.back().first[0];
        end_before = end;
      });
    }
    first_run_.push_back(static_cast<std::int32_t>(runs_.size()));
  }
  runs_.shrink_to_fit();
  for (CellRun& run : runs_) {
    run.cell_slot = n_cell_slots_;
    n_cell_slots_ += block * run.blocks();
  }
}

/// A row of nodes is the union of the nodes that the runs of its four rows of cells reach.
void MaskedRows::place_nodes(const Grid& grid) {
  const Index3 &cells = grid.cells(), &nodes = grid.nodes();
  List<std::int32_t> first_of_row; // of cells
  std::int32_t next = 0;
  for (int z = layers_.first; z < layers_.end; ++z)
    for (int y = 0; y < cells[1]; ++y) {
      first_of_row.push_back(next);
      while (next < std::ssize(runs_) && runs_[next].first[2] == z && runs_[next].first[1] == y)
        ++next;
    }
  first_of_row.push_back(next);
  first_row_.push_back(0);
  std::vector<std::pair<int, int>> reached; // first node, and the end
  for (int z = layers_.first; z <= layers_.end; ++z) {
    n_slots_ += z % planes_per_slab == 0 ? block : 0;
    first_slot_.push_back(z == layers_.first ? 0 : n_slots_);
    for (int y = 0; y < nodes[1]; ++y) {
      reached.clear();
      for (const int cell_z : {z - 1, z})
        for (const int cell_y : {y - 1, y}) {
          if (cell_z < layers_.first || cell_z >= layers_.end || cell_y < 0 || cell_y >= cells[1])
            continue;
          const auto row =
              static_cast<std::size_t>(cell_y) +
              static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(cell_z - layers_.first);
          for (auto i = static_cast<std::size_t>(first_of_row[row]);
               i < static_cast<std::size_t>(first_of_row[row + 1]); ++i)
            reached.emplace_back(runs_[i].first[0], runs_[i].first[0] + runs_[i].cells + 1);
        }
      std::ranges::sort(reached);
      int end = -1;
      for (const auto& [first, its_end] : reached) {
        if (first > end)
          node_rows_.push_back({{first, y, z}, n_slots_, 0});
        if (its_end > end) {
          NodeRow& row = node_rows_.back();
          n_slots_ += its_end - row.first[0] - row.nodes;
          row.nodes = its_end - row.first[0];
          end = its_end;
        }
      }
      first_row_.push_back(static_cast<std::int32_t>(node_rows_.size()));
    }
  }
  node_rows_.shrink_to_fit();
  n_slots_of_rows_ = n_slots_;
  n_slots_ = static_cast<std::int32_t>(n_slots_for(n_slots_));
  first_slot_.push_back(n_slots_);
}

std::int32_t MaskedRows::slot(const Index3& node) const {
  const auto row = static_cast<std::size_t>(node[1] + rows_in_plane_ * (node[2] - layers_.first));
  auto i = static_cast<std::size_t>(first_row_[row + 1] - 1);
  while (node_rows_[i].first[0] > node[0])
    --i;
  return node_rows_[i].slot + node[0] - node_rows_[i].first[0];
}

} // namespace maille::deform
