#include "bench/studies/scene_maker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace maille::lab {

std::string isotropic(double nu, const char* youngs_modulus) {
  return fmt::format("{{ youngs_modulus = \"{}\", poisson_ratio = {}, density = \"1050 kg/m^3\" }}",
                     youngs_modulus, nu);
}

std::string fibres(double ratio, double angle) {
  return fmt::format(
      "{{ E_fibre = \"{} kPa\", E_cross = \"10 kPa\", G_fibre = \"4 kPa\", nu_fibre = 0.3, nu_cross = "
      "0.4, density = \"1050 kg/m^3\" }}\nfibre = {{ angle = \"{} deg\", plane = \"xz\" }}",
      10 * ratio, angle);
}

std::string held(const char* where) {
  return fmt::format("[[hold]]\nwhere = \"{}\"\n", where);
}

std::string moved(const char* where, double x, double y, double z) {
  return fmt::format("[[move]]\nwhere = \"{}\"\nby = [\"{} mm\", \"{} mm\", \"{} mm\"]\n", where, x, y, z);
}

std::string calf_muscle(int label, const std::string& material, const std::array<int, 3>& blocks) {
  return fmt::format("[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/calf_mri/labels.nii.gz\"\n"
                     "labels = {{ {} = {} }}\nfibre = [0, 0, 1]\ncoarsen = [{}, {}, {}]\n",
                     label, material, blocks[0], blocks[1], blocks[2]);
}

std::string head(int threshold, const std::string& material, int block) {
  return fmt::format("[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/head_ct/headsq.mha\"\n"
                     "threshold = {}\nmaterial = {}\ncoarsen = {}\n",
                     threshold, material, block);
}

std::string action(const std::string& word, const std::array<double, 3>& mm) {
  const auto [length, width, height] = mm;
  if (word == "pull")
    return held("x-") + moved("x+", 0.05 * length, 0, 0);
  if (word == "bend")
    return held("x-") + moved("x+", 0, 0, 0.05 * length);
  if (word == "shear")
    return held("z-") + moved("z+", 0.1 * height, 0, 0);
  if (word == "squeeze")
    return held("z-") + moved("z+", 0, 0, -0.05 * height);
  if (word == "twist")
    return held("x-") + "[[move]]\nwhere = \"x+\"\nturn = { angle = \"6 deg\", axis = [1, 0, 0] }\n";
  if (word == "gravity")
    return held("x-") + "[[load]]\ngravity = [0, 0, -1]\n";
  if (word == "traction")
    return held("x-") + "[[load]]\nwhere = \"x+\"\ntraction = [0, 0, 20]\n";
  if (word == "hinge") // a line of nodes
    return fmt::format(
               "[[hold]]\nwhere = {{ box = [[\"-0.1 mm\", \"-0.1 mm\", \"-0.1 mm\"], [\"0.1 mm\", \"{} mm\", "
               "\"0.1 mm\"]] }}\n",
               width + 0.1) +
           moved("x+", 0, 0, 0.05 * length);
  if (word == "plane bend")
    return held("x-") + "[[hold]]\nwhere = \"y-\"\naxes = \"y\"\n[[hold]]\nwhere = \"y+\"\naxes = \"y\"\n" +
           "[[move]]\nwhere = \"x+\"\nby = [0, 0, \"" + fmt::format("{}", 0.02 * length) +
           " mm\"]\naxes = \"xz\"\n";
  return held("z-") + fmt::format("[[move]]\nwhere = {{ box = [[\"{} mm\", \"{} mm\", \"{} mm\"], [\"{} "
                                  "mm\", \"{} mm\", \"{} mm\"]] }}\nby = [0, 0, \"{} mm\"]\n",
                                  length / 4, width / 4, height - 0.1, length - length / 4, width - width / 4,
                                  height + 0.1, -0.05 * height);
}

void SceneMaker::box(const std::string& words, const Cells& cells, const std::string& material,
                     const std::string& word, const Point& spacing) {
  scenes_.push_back(
      {fmt::format("{}, {}", words, word),
       fmt::format("[specimen]\nshape = \"box\"\ncells = [{}, {}, {}]\nspacing = [\"{} mm\", \"{} mm\", "
                   "\"{} mm\"]\nmaterial = {}\n",
                   scale_ * cells[0], scale_ * cells[1], scale_ * cells[2], spacing[0] / scale_,
                   spacing[1] / scale_, spacing[2] / scale_, material) +
           action(word, {cells[0] * spacing[0], cells[1] * spacing[1], cells[2] * spacing[2]})});
}

void SceneMaker::image(const LabelledBody& body, const std::vector<std::string>& words) {
  const auto& [name, cells, materials, label] = body;
  const std::string file_name = fmt::format("kind_{}.mha", scenes_.size());
  const double side = 1.0 / scale_;
  std::ofstream file(folder_ / file_name, std::ios::binary);
  file << fmt::format("ObjectType = Image\nNDims = 3\nDimSize = {} {} {}\nElementSpacing = {} {} {}\n"
                      "Offset = {} {} {}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
                      scale_ * cells[0], scale_ * cells[1], scale_ * cells[2], side, side, side, side / 2,
                      side / 2, side / 2);
  for (int z = 0; z < scale_ * cells[2]; ++z)
    for (int y = 0; y < scale_ * cells[1]; ++y)
      for (int x = 0; x < scale_ * cells[0]; ++x)
        file.put(static_cast<char>(label({(x + 0.5) * side, (y + 0.5) * side, (z + 0.5) * side})));
  std::string labels;
  for (std::size_t i = 0; i < materials.size(); ++i)
    labels += fmt::format("{}{} = {}", i > 0 ? ", " : "", i + 1, materials[i]);
  for (const std::string& word : words)
    scenes_.push_back({fmt::format("{}, {}", name, word),
                       fmt::format("[specimen]\nshape = \"image\"\nimage = \"{}\"\nlabels = {{ {} }}\n",
                                   file_name, labels) +
                           action(word, {static_cast<double>(cells[0]), static_cast<double>(cells[1]),
                                         static_cast<double>(cells[2])})});
}

std::vector<std::string> stiff_and_soft() {
  return {isotropic(0.3, "1 MPa"), isotropic(0.49, "10 kPa")};
}

std::vector<std::string> soft_tissues() {
  return {isotropic(0.45, "20 kPa"), isotropic(0.48, "3 kPa"), isotropic(0.45, "100 kPa")};
}

bool is_inside_shell(const LabelledBody::Point& at) {
  return std::ranges::all_of(at, [](double x) { return x > 1 && x < 7; });
}

LabelledBody body_under_skin() {
  return {"muscle, fat, a skin of 1 mm", {10, 8, 8}, soft_tissues(), [](const LabelledBody::Point& at) {
            return at[2] > 7 ? 3 : at[2] > 5 ? 2 : 1;
          }};
}

LabelledBody body_with_soft_seam() {
  return {"soft seam of 1 mm", {10, 6, 6}, stiff_and_soft(), [](const LabelledBody::Point& at) {
            return at[0] > 5 && at[0] < 6 ? 2 : 1;
          }};
}

LabelledBody gel_with_stiff_sheet() {
  return {"stiff sheet of 1 mm in gel", {10, 6, 6}, stiff_and_soft(), [](const LabelledBody::Point& at) {
            return at[1] > 3 && at[1] < 4 ? 1 : 2;
          }};
}

LabelledBody checkerboard() {
  return {"checkerboard, 1:100", {8, 8, 6}, stiff_and_soft(), [](const LabelledBody::Point& at) {
            int steps = 0;
            for (const double x : at)
              steps += static_cast<int>(x / 2);
            return 1 + steps % 2;
          }};
}

LabelledBody shell_around_gel() {
  return {"shell of 1 mm around gel", {8, 8, 8}, stiff_and_soft(), [](const LabelledBody::Point& at) {
            return is_inside_shell(at) ? 2 : 1;
          }};
}

LabelledBody body_like_an_l() {
  return {"an L", {10, 6, 8}, {isotropic(0.4)}, [](const LabelledBody::Point& at) {
            return at[0] < 4 || at[2] < 3 ? 1 : 0;
          }};
}

std::vector<std::size_t> spread(std::size_t n, std::size_t wanted) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < std::min(n, wanted); ++i)
    numbers.push_back(i * n / std::min(n, wanted));
  return numbers;
}

} // namespace maille::lab
