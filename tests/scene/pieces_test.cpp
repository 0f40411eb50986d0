// Pieces from runs of cells, against a flood that goes from cell to cell.

#include "geometry/pieces.hpp"
#include "support/kit.hpp"

namespace {

using namespace maille;

struct Flooded {
  std::vector<std::int32_t> of_cell; ///< -1: no matter
  std::vector<BodyPieces::Piece> pieces;
};

Flooded flood(const Specimen& body) {
  const Grid& grid = body.grid;
  Flooded result{std::vector<std::int32_t>(std::size_t(grid.n_cells()), -1), {}};
  for (std::int64_t seed = 0; seed < grid.n_cells(); ++seed) {
    if (!body.is_matter(seed) || result.of_cell[std::size_t(seed)] >= 0)
      continue;
    const auto number = static_cast<std::int32_t>(result.pieces.size());
    BodyPieces::Piece piece{0, seed, grid.cell_at(seed), grid.cell_at(seed)};
    std::vector<std::int64_t> open{seed};
    result.of_cell[std::size_t(seed)] = number;
    while (!open.empty()) {
      const Index3 at = grid.cell_at(open.back());
      open.pop_back();
      ++piece.cells;
      for (std::size_t a = 0; a < 3; ++a) {
        piece.lower[a] = std::min(piece.lower[a], at[a]);
        piece.upper[a] = std::max(piece.upper[a], at[a] + 1);
        for (const int step : {-1, 1}) {
          Index3 next = at;
          next[a] += step;
          if (!grid.has_cell(next) || !body.is_matter(grid.cell(next)) ||
              result.of_cell[std::size_t(grid.cell(next))] >= 0)
            continue;
          result.of_cell[std::size_t(grid.cell(next))] = number;
          open.push_back(grid.cell(next));
        }
      }
    }
    result.pieces.push_back(piece);
  }
  return result;
}

std::set<std::int32_t> at_node(const Specimen& body, const Flooded& flooded, const Index3& node) {
  std::set<std::int32_t> found;
  body.for_each_cell_at(node, [&](std::int64_t cell) { found.insert(flooded.of_cell[std::size_t(cell)]); });
  return found;
}

Specimen random_body(int dimension, const Index3& cells, double share, std::mt19937& random) {
  Specimen body;
  body.grid = Grid(dimension, cells, {1, 1, 1});
  std::bernoulli_distribution is_matter(share);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    body.material_id.push_back(is_matter(random) ? std::uint8_t{3} : no_material);
  return body;
}

void expect_same(const Specimen& body) {
  const BodyPieces found(body);
  const Flooded flooded = flood(body);
  ASSERT_EQ(found.pieces().size(), flooded.pieces.size());
  for (std::size_t i = 0; i < flooded.pieces.size(); ++i) {
    EXPECT_EQ(found.pieces()[i].cells, flooded.pieces[i].cells);
    EXPECT_EQ(found.pieces()[i].first_cell, flooded.pieces[i].first_cell);
    EXPECT_EQ(found.pieces()[i].lower, flooded.pieces[i].lower);
    EXPECT_EQ(found.pieces()[i].upper, flooded.pieces[i].upper);
  }
  std::vector<std::int32_t> of_cell(flooded.of_cell.size(), -1);
  for (std::int64_t row = 0; row < found.n_rows(); ++row)
    for (const BodyPieces::Run& run : found.runs_of_row(row))
      for (int x = run.begin; x < run.end; ++x)
        of_cell[std::size_t(row * body.grid.cells()[0] + x)] = run.piece;
  EXPECT_EQ(of_cell, flooded.of_cell);
  std::vector<std::int64_t> shared;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    const Index3 at = body.grid.node_at(node);
    const std::set<std::int32_t> there = at_node(body, flooded, at);
    EXPECT_EQ(found.at_node(at), std::vector<std::int32_t>(there.begin(), there.end()));
    if (there.size() > 1)
      shared.push_back(node);
  }
  EXPECT_EQ(found.shared_nodes(), shared);
}

TEST(BodyPiecesOracle, RunsFindWhatAFloodFinds) {
  std::mt19937 random(20); // any
  for (const double share : {0.05, 0.3, 0.5, 0.7, 0.95})
    for (int repeat = 0; repeat < 20; ++repeat) {
      expect_same(random_body(1, {37, 1, 1}, share, random));
      expect_same(random_body(2, {19, 11, 1}, share, random));
      expect_same(random_body(3, {9, 7, 6}, share, random));
      expect_same(random_body(3, {33, 2, 3}, share, random)); // runs of eight without matter
    }
}

TEST(BodyPiecesAnalytic, AFullBoxIsOnePiece) {
  Specimen body;
  body.grid = Grid(3, {5, 4, 3}, {1, 1, 1});
  const BodyPieces found(body);
  ASSERT_EQ(found.pieces().size(), 1U);
  EXPECT_EQ(found.pieces()[0].cells, 60);
  EXPECT_EQ(found.pieces()[0].upper, (Index3{5, 4, 3}));
  EXPECT_TRUE(found.shared_nodes().empty());
}

} // namespace
