#include "results/scene_tables.hpp"

namespace maille::studies {

const ResultTable<ModelPart>& columns_of_model() {
  static const ResultTable<ModelPart> table([](ResultTable<ModelPart>& columns) {
    columns.add({}, {"is", -3}, [](const ModelPart& part) { return part.on ? "on" : "off"; });
    columns.add({"", "name", "", "of the part"}, {"part of the model", -21}, &ModelPart::name);
    columns.add({"", "on", "", "whether the scene switches it on"}, &ModelPart::on);
    columns.add({"", "why", "", "in words"}, {"why"}, &ModelPart::why);
  });
  return table;
}

const ResultTable<Fault>& columns_of_faults() {
  static const ResultTable<Fault> table([](ResultTable<Fault>& columns) {
    columns.add({"", "file", "", "as it was named"}, &Fault::file);
    columns.add({"", "line", "", "from 1; 0: of the whole file"}, &Fault::line);
    columns.add({"", "key", "", "its path, such as specimen.spacing"}, &Fault::key);
    columns.add({"", "expected", "", "in words"}, &Fault::expected);
    columns.add({"", "found", "", "in words"}, &Fault::found);
  });
  return table;
}

const ResultTable<NeighbourLimits>& columns_of_limits() {
  static const ResultTable<NeighbourLimits> table([](ResultTable<NeighbourLimits>& columns) {
    columns.add({"", "stretch", "", "largest length over that at rest, axes 1 2 3"},
                &NeighbourLimits::stretch);
    columns.add({"", "compress", "", "least length over that at rest"}, &NeighbourLimits::compress);
    columns.add({"", "shear", "", "over the length at rest, by axis of the link and of the displacement"},
                &NeighbourLimits::shear);
  });
  return table;
}

const ResultTable<LeftOutPiece>& columns_of_left_out() {
  static const ResultTable<LeftOutPiece> table([](ResultTable<LeftOutPiece>& columns) {
    columns.add({"", "cells", "", "of the piece"}, &LeftOutPiece::cells);
    columns.add({"", "name", "", "where it is"}, &LeftOutPiece::name);
  });
  return table;
}

std::string name_of(ObjectKind kind) {
  return kind == ObjectKind::fixed ? "fixed" : kind == ObjectKind::rigid ? "rigid" : "deformable";
}

} // namespace maille::studies
