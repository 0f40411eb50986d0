#include "bench/studies/kind_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <utility>

namespace maille::studies {

namespace {

using Cells = std::array<int, 3>;

std::string isotropic(double nu, const char* E = "10 kPa") {
  return fmt::format("{{ youngs_modulus = \"{}\", poisson_ratio = {}, density = \"1050 kg/m^3\" }}", E, nu);
}

/// Fibres `ratio` times as stiff along as across, turned by an angle in the xz plane.
std::string fibres(double ratio, double angle) {
  return fmt::format(
      "{{ E_fibre = \"{} kPa\", E_cross = \"10 kPa\", G_fibre = \"4 kPa\", nu_fibre = 0.3, nu_cross = "
      "0.4 }}\nfibre = {{ angle = \"{} deg\", plane = \"xz\" }}",
      10 * ratio, angle);
}

std::string held(const char* where) {
  return fmt::format("[[hold]]\nwhere = \"{}\"\n", where);
}

std::string moved(const char* where, double x, double y, double z) {
  return fmt::format("[[move]]\nwhere = \"{}\"\nby = [\"{} mm\", \"{} mm\", \"{} mm\"]\n", where, x, y, z);
}

/// What is done to a body of so many millimetres.
std::string action(const std::string& word, const Cells& mm) {
  const double length = mm[0], height = mm[2];
  if (word == "pull")
    return held("x-") + moved("x+", 0.05 * length, 0, 0);
  if (word == "bend")
    return held("x-") + moved("x+", 0, 0, 0.05 * length);
  if (word == "shear")
    return held("z-") + moved("z+", 0.1 * height, 0, 0);
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
               mm[1] + 0.1) +
           moved("x+", 0, 0, 0.05 * length);
  if (word == "plane bend") // nothing moves across
    return held("x-") + "[[hold]]\nwhere = \"y-\"\naxes = \"y\"\n[[hold]]\nwhere = \"y+\"\naxes = \"y\"\n" +
           "[[move]]\nwhere = \"x+\"\nby = [0, 0, \"" + fmt::format("{}", 0.02 * length) +
           " mm\"]\naxes = \"xz\"\n";
  return held("z-") + // poke: the middle half of the top
         fmt::format("[[move]]\nwhere = {{ box = [[\"{} mm\", \"{} mm\", \"{} mm\"], [\"{} mm\", \"{} mm\", "
                     "\"{} mm\"]] "
                     "}}\nby = [0, 0, \"{} mm\"]\n",
                     mm[0] / 4, mm[1] / 4, height - 0.1, mm[0] - mm[0] / 4, mm[1] - mm[1] / 4, height + 0.1,
                     -0.05 * height);
}

class Kinds {
public:
  Kinds(int scale, std::filesystem::path folder) : scale_(scale), folder_(std::move(folder)) {}

  void box(const std::string& words, const Cells& mm, const std::string& material, const std::string& word,
           const char* spacing = "1 mm") {
    const double size = std::atof(spacing);
    scenes_.push_back(
        {fmt::format("{}, {}", words, word),
         fmt::format("[specimen]\nshape = \"box\"\ncells = [{}, {}, {}]\nspacing = \"{} mm\"\nmaterial = "
                     "{}\n",
                     scale_ * mm[0], scale_ * mm[1], scale_ * mm[2], size / scale_, material) +
             action(word, mm)});
  }

  /// @param label of every cell of 1 mm, from 0: nothing @param materials of labels 1, 2, ...
  void layers(const std::string& words, const Cells& mm, const std::vector<std::string>& materials,
              const std::function<int(const Cells&)>& label, const std::string& word) {
    const std::string name = fmt::format("kind_{}.mha", scenes_.size());
    std::ofstream file(folder_ / name, std::ios::binary);
    file << fmt::format(
        "ObjectType = Image\nNDims = 3\nDimSize = {} {} {}\nElementSpacing = {} {} {}\nOffset = {} {} "
        "{}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        scale_ * mm[0], scale_ * mm[1], scale_ * mm[2], 1.0 / scale_, 1.0 / scale_, 1.0 / scale_,
        0.5 / scale_, 0.5 / scale_, 0.5 / scale_);
    for (int z = 0; z < scale_ * mm[2]; ++z)
      for (int y = 0; y < scale_ * mm[1]; ++y)
        for (int x = 0; x < scale_ * mm[0]; ++x)
          file.put(static_cast<char>(label({x / scale_, y / scale_, z / scale_})));
    std::string labels;
    for (std::size_t i = 0; i < materials.size(); ++i)
      labels += fmt::format("{}{} = {}", i > 0 ? ", " : "", i + 1, materials[i]);
    scenes_.push_back(
        {fmt::format("{}, {}", words, word),
         fmt::format("[specimen]\nshape = \"image\"\nimage = \"{}\"\nlabels = {{ {} }}\n", name, labels) +
             action(word, mm)});
  }

  void add(const std::string& words, const std::string& text) { scenes_.push_back({words, text}); }
  int scale() const { return scale_; }
  std::vector<KindScene> take() { return std::move(scenes_); }

private:
  int scale_;
  std::filesystem::path folder_;
  std::vector<KindScene> scenes_;
};

void add_boxes(Kinds& kinds) {
  for (const double nu : {0.3, 0.45, 0.49, 0.499, 0.4999})
    for (const char* word : {"poke", "shear", "pull", "bend"})
      kinds.box(fmt::format("box, nu {}", nu), {12, 8, 8}, isotropic(nu), word);
  kinds.box("flat cells, nu 0.3", {12, 12, 6}, isotropic(0.3), "bend", "0.5 mm");
  for (const double nu : {0.3, 0.49})
    for (const char* word : {"bend", "twist"})
      kinds.box(fmt::format("slender, nu {}", nu), {24, 4, 4}, isotropic(nu), word);
  for (const double nu : {0.3, 0.45})
    kinds.box(fmt::format("held along an edge, nu {}", nu), {12, 8, 4}, isotropic(nu), "hinge");
  kinds.box("box, nu 0.3", {10, 8, 8}, isotropic(0.3), "gravity");
  kinds.box("box, nu 0.49", {10, 8, 8}, isotropic(0.49), "gravity");
  kinds.box("box, nu 0.45", {10, 8, 8}, isotropic(0.45), "traction");
}

void add_plates(Kinds& kinds) {
  for (const double nu : {0.3, 0.45, 0.49})
    kinds.box(fmt::format("plate one cell thick, nu {}", nu), {16, 12, 1}, isotropic(nu), "bend");
  for (const double nu : {0.3, 0.45}) {
    kinds.box(fmt::format("strip one cell thick, nu {}", nu), {16, 4, 1}, isotropic(nu), "plane bend");
    kinds.box(fmt::format("plate one cell thick, nu {}", nu), {16, 16, 1}, isotropic(nu, "1 MPa"), "gravity");
    kinds.box(fmt::format("plate two cells thick, nu {}", nu), {16, 16, 2}, isotropic(nu), "bend");
  }
}

void add_fibres(Kinds& kinds) {
  kinds.box("fibres 50:1 at 30 deg", {12, 8, 8}, fibres(50, 30), "pull");
  kinds.box("fibres 50:1 at 45 deg", {12, 8, 8}, fibres(50, 45), "bend");
  kinds.box("fibres 20:1 at 60 deg", {12, 8, 8}, fibres(20, 60), "shear");
  kinds.box("fibres 20:1, thin", {16, 8, 2}, fibres(20, 20), "pull");
  kinds.box("muscle/strongly_anisotropic", {12, 8, 8}, "\"muscle/strongly_anisotropic\"", "poke");
}

void add_layers(Kinds& kinds) {
  const std::vector<std::string> tissues{isotropic(0.45, "20 kPa"), isotropic(0.48, "3 kPa"),
                                         isotropic(0.45, "100 kPa")};
  const auto skin = [](const Cells& at) { return at[2] == 7 ? 3 : at[2] >= 5 ? 2 : 1; };
  for (const char* word : {"poke", "shear", "bend"})
    kinds.layers("muscle, fat, a skin of 1 mm", {10, 8, 8}, tissues, skin, word);
  const std::vector<std::string> contrast{isotropic(0.3, "1 MPa"), isotropic(0.49, "10 kPa")};
  kinds.layers(
      "soft seam of 1 mm", {10, 6, 6}, contrast, [](const Cells& at) { return at[0] == 5 ? 2 : 1; }, "pull");
  kinds.layers(
      "checkerboard, 1:100", {8, 8, 6}, contrast,
      [](const Cells& at) { return 1 + (at[0] / 2 + at[1] / 2 + at[2] / 2) % 2; }, "shear");
  kinds.layers(
      "stiff sheet of 1 mm in gel", {10, 6, 6}, contrast, [](const Cells& at) { return at[1] == 3 ? 1 : 2; },
      "bend");
  kinds.layers(
      "shell of 1 mm around gel", {8, 8, 8}, contrast,
      [](const Cells& at) {
        bool is_outer = false;
        for (const int i : at)
          is_outer = is_outer || i == 0 || i == 7;
        return is_outer ? 1 : 2;
      },
      "shear");
  kinds.layers(
      "an L", {10, 6, 8}, {isotropic(0.4)}, [](const Cells& at) { return at[0] < 4 || at[2] < 3 ? 1 : 0; },
      "pull");
}

void add_muscles(Kinds& kinds) {
  const int s = kinds.scale();
  kinds.add(
      "belly with tendons, pulled",
      fmt::format(
          "[specimen]\nshape = \"muscle\"\ncells = [{}, {}, {}]\nspacing = \"{} mm\"\nmaterial = "
          "\"muscle/soleus\"\ntendon = {{ material = \"tendon/tibialis_anterior\", fraction = 0.15 }}\n",
          16 * s, 8 * s, 8 * s, 1.0 / s) +
          action("pull", {16, 8, 8}));
  if (const char* data = std::getenv("MAILLE_DATA"); !data || !*data)
    return;
  const std::string block = s == 1 ? "coarsen = [2, 2, 1]\n" : "";
  const std::string moved_end = held("z-") + moved("z+", 0, 0, 7);
  // Constants of their own: the library's muscles have limits, which would bind.
  const std::string pulp =
      "{ E_fibre = \"200 kPa\", E_cross = \"10 kPa\", G_fibre = \"4 kPa\", nu_fibre = 0.3, nu_cross = 0.4 }";
  const auto muscle = [&](int label, const std::string& material) {
    return fmt::format(
        "[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/calf_mri/labels.nii.gz\"\nlabels = {{ {} = {} "
        "}}\nfibre = [0, 0, 1]\n{}",
        label, material, block);
  };
  kinds.add("muscle 17 of a calf from MRI, pulled", muscle(17, "\"muscle/soleus\"") + moved_end);
  kinds.add("muscle 24 of a calf from MRI, fibres 20:1, pulled", muscle(24, pulp) + moved_end);
  kinds.add("muscle 19 of a calf from MRI, gravity",
            muscle(19, isotropic(0.45, "50 kPa")) + held("z-") + "[[load]]\ngravity = [1, 0, 0]\n");
  kinds.add(
      "head from CT, pressed",
      fmt::format(
          "[specimen]\nshape = \"image\"\nimage = \"$MAILLE_DATA/head_ct/headsq.mha\"\nthreshold = 300\n"
          "material = {}\ncoarsen = {}\n",
          isotropic(0.3, "1 MPa"), 8 / s) +
          held("z-") + moved("z+", 0, 0, -1));
}

} // namespace

KindScenes::KindScenes(int scale) : folder_("maille_kinds") {
  Kinds kinds(scale, folder_.path());
  add_boxes(kinds);
  add_plates(kinds);
  add_fibres(kinds);
  add_layers(kinds);
  add_muscles(kinds);
  scenes_ = kinds.take();
}

std::vector<std::size_t> spread(std::size_t n, std::size_t wanted) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < std::min(n, wanted); ++i)
    numbers.push_back(i * n / std::min(n, wanted));
  return numbers;
}

} // namespace maille::studies
