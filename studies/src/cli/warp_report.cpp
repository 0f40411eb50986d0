#include "cli/outputs.hpp"

#include "results/result_table.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <iterator>

namespace maille::studies {

namespace {

std::string in_millilitres(double cubic_metres) {
  return fmt::format("{:.4g} ml", 1e6 * cubic_metres);
}

std::string in_millimetres(const Vec3& x) {
  return fmt::format("{:.1f} {:.1f} {:.1f}", 1e3 * x[0], 1e3 * x[1], 1e3 * x[2]);
}

const ResultTable<WarpedLabel>& columns_of_labels() {
  static const ResultTable<WarpedLabel> table([](ResultTable<WarpedLabel>& columns) {
    columns.add({"label", "label", "", "in the image of labels"}, {"label"}, &WarpedLabel::label);
    columns.add({"voxels", "voxels", "", "at rest, in matter of the body"}, {"voxels"}, &WarpedLabel::voxels);
    columns.add({"warped_voxels", "warped_voxels", "", "that the label has in the warped image"}, {"warped"},
                &WarpedLabel::warped);
    columns.add({"volume_at_rest", "volume_at_rest_m3", "m^3", "of its voxels at rest"},
                {"at rest", 0, in_millilitres}, &WarpedLabel::volume_at_rest);
    columns.add({"volume", "volume_m3", "m^3", "of its voxels in the warped image"},
                {"warped volume", 0, in_millilitres}, &WarpedLabel::volume);
    columns.add({"sub_voxel_volume", "sub_voxel_volume_m3", "m^3",
                 "that it fills in the warped image, parts of voxels included"},
                {"sub-voxel volume", 0, in_millilitres}, &WarpedLabel::sub_voxel_volume);
    columns.add({"integral_of_det_f", "integral_of_det_f_m3", "m^3", "det F over its voxels at rest"},
                {"integral of det F", 0, in_millilitres}, &WarpedLabel::integral_of_det_f);
    columns.add({"", "centroid_at_rest_m", "m", "of its voxels at rest, in the image's world"},
                &WarpedLabel::centroid_at_rest, [](const Vec3& x) { return nlohmann::ordered_json(x); });
    columns.add({"", "centroid_m", "m", "of its voxels in the warped image"}, &WarpedLabel::centroid,
                [](const Vec3& x) { return nlohmann::ordered_json(x); });
    columns.add({}, {"centroid [mm]", -24}, &WarpedLabel::centroid, in_millimetres);
    columns.add({"folded_cells", "folded_cells", "", "cells at whose middle it is that are folded"},
                {"folded"}, &WarpedLabel::folded);
    columns.add({"voxels_left_out", "voxels_left_out", "", "at rest, in no body"}, {"left out"},
                &WarpedLabel::left_out);
  });
  return table;
}

} // namespace

std::string in_words(const WarpedFiles& made) {
  std::vector<WarpedLabel> of_body; // the warning lists the others
  std::ranges::copy_if(made.labels, std::back_inserter(of_body),
                       [](const WarpedLabel& label) { return label.voxels > 0 || label.warped > 0; });
  std::string text = of_body.empty() ? "" : columns_of_labels().text(of_body);
  text += fmt::format("{} voxels of matter at rest, {} now; {} were left and are background\n", made.at_rest,
                      made.reached, made.vacated);
  for (const std::string& warning : made.warnings)
    text += "warning: " + warning + "\n";
  return text;
}

nlohmann::ordered_json json(const WarpedFiles& made) {
  nlohmann::ordered_json out{
      {"voxels_at_rest", made.at_rest},           {"voxels", made.reached},
      {"voxels_vacated", made.vacated},           {"voxels_reached_twice", made.reached_twice},
      {"folded_cells", made.folded_cells},        {"labels", columns_of_labels().json_rows(made.labels)},
      {"files", nlohmann::ordered_json::array()}, {"warnings", made.warnings}};
  for (const auto& file : made.files)
    out["files"].push_back(file.filename().string());
  return out;
}

} // namespace maille::studies
