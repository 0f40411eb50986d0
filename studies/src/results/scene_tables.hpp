#pragma once
/// Shared result tables about a scene and its file: errors, proportions, material limits, active model
/// features, omissions.

#include "maille/materials/fault.hpp"
#include "maille/materials/material.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "results/result_table.hpp"
#include "text.hpp"

namespace maille::studies {

/// One model feature, whether the scene uses it, and why.
struct ModelPart {
  std::string name;
  bool on = false;
  std::string why;
};

const ResultTable<ModelPart>& columns_of_model();
const ResultTable<Fault>& columns_of_faults();
const ResultTable<NeighbourLimits>& columns_of_limits();
const ResultTable<LeftOutPiece>& columns_of_left_out();

/// `fixed`, `rigid` or `deformable`, as in scene files.
std::string name_of(ObjectKind kind);

/// Adds sizes, strains and warnings. @param path to Plausibility, perhaps optional: then JSON omits missing
/// ones
/// @param has true if a row has them
template<class Row, class... Path>
void add_plausibility(ResultTable<Row>& columns, typename ResultTable<Row>::Condition has, Path... path) {
  const auto add = [&](const char* key, const char* unit, const char* meaning, auto figure) {
    columns.add({"", key, unit, meaning}, path..., figure).json_where(has);
  };
  add("size_m", "m", "of the box around the matter", &Plausibility::size);
  add("largest_move_m", "m", "largest prescribed displacement", &Plausibility::largest_move);
  add("move_over_length", "", "that over the longest side of the box", &Plausibility::move_over_length);
  add("mean_strain", "", "that the moves ask for on the way", &Plausibility::mean_strain);
  add("strain_of_loads", "", "largest traction over the least modulus", &Plausibility::strain_of_loads);
  add("warnings", "", "what is out of proportion, in words", &Plausibility::warnings);
}

} // namespace maille::studies
