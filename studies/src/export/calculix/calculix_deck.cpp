#include "export/body_numbering.hpp"
#include "export/calculix/calculix.hpp"
#include "maille/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace maille::studies {

namespace {

/// Corners of a brick in the order of C3D8, as bits x y z.
constexpr std::array<int, 8> brick{0, 1, 3, 2, 4, 5, 7, 6};

/// 19 characters at most, 13 digits.
std::string number(double value) {
  return fmt::format("{:.12e}", value);
}

class Deck {
public:
  explicit Deck(const Scene& scene);
  std::string text() const { return head_ + model_ + step_; }

private:
  void write_nodes();
  void write_elements();
  void write_ties();
  void write_materials();
  void write_conditions();
  void write_forces();
  void write_pressures();

  std::int64_t id(std::int64_t node, int copy) const {
    return number_[node] + 1 + copy * static_cast<std::int64_t>(nodes_.size());
  }
  /// Kind of a cell: its material and, unless it is isotropic, its fibre.
  using Kind = std::array<double, 4>;
  Kind kind_of(std::int64_t cell) const;

  const Scene& scene_;
  const Grid& grid_;
  int d_, copies_;
  std::vector<std::int64_t> nodes_, number_;
  std::map<Kind, std::pair<int, std::int64_t>> kinds_; ///< number, from 1, and an example cell
  std::string head_, model_, step_;
  bool is_finite_;
};

Deck::Deck(const Scene& scene)
    : scene_(scene), grid_(scene.specimen.grid), d_(scene.dimension()), copies_(1 << (3 - d_)),
      nodes_(matter_only(scene.specimen).nodes), number_(static_cast<std::size_t>(grid_.n_nodes()), -1) {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    number_[nodes_[i]] = static_cast<std::int64_t>(i);
  std::string name = scene.name; // one line, for any file name
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c == 127; }, '_');
  head_ = fmt::format("*HEADING\n** scene {}: {} cells, {} nodes, {}D; SI units\n", name,
                      scene.specimen.n_matter_cells(), nodes_.size(), d_);
  is_finite_ = scene.strain == Strain::finite;
  write_nodes();
  write_elements();
  write_ties();
  write_materials();
  step_ = is_finite_ ? "*STEP, NLGEOM, INC=1000\n*STATIC, SOLVER=SPOOLES\n0.1,1.\n"
                     : "*STEP\n*STATIC, SOLVER=SPOOLES\n";
  write_conditions();
  write_forces();
  if (is_finite_)
    write_pressures();
  step_ += "*NODE PRINT, NSET=BODY\nU\n*NODE FILE\nU\n*EL FILE\nS, E\n*END STEP\n";
}

void Deck::write_nodes() {
  model_ += "*NODE, NSET=ALL\n";
  for (int copy = 0; copy < copies_; ++copy)
    for (const std::int64_t node : nodes_) {
      Vec3 x = scene_.specimen.position(grid_.node_at(node));
      for (int axis = d_; axis < 3; ++axis)
        x[axis] = copy >> (axis - d_) & 1; // a layer 1 m thick
      model_ += fmt::format("{},{},{},{}\n", id(node, copy), number(x[0]), number(x[1]), number(x[2]));
    }
  model_ += fmt::format("*NSET, NSET=BODY, GENERATE\n1,{},1\n", nodes_.size());
}

Deck::Kind Deck::kind_of(std::int64_t cell) const {
  const std::uint8_t material = scene_.specimen.material(cell);
  if (scene_.materials[material].elasticity.is_isotropic())
    return {double(material), 0, 0, 0};
  const Vec3 f = scene_.specimen.fibre_of(cell);
  return {double(material), f[0], f[1], f[2]};
}

void Deck::write_elements() {
  std::map<int, std::string> of_kind;
  std::int64_t element = 0;
  for (std::int64_t cell = 0; cell < grid_.n_cells(); ++cell) {
    if (!scene_.specimen.is_matter(cell))
      continue;
    const int next = static_cast<int>(kinds_.size()) + 1;
    const int kind = kinds_.try_emplace(kind_of(cell), next, cell).first->second.first;
    std::string& lines = of_kind[kind];
    lines += std::to_string(++element);
    const int in_grid = (1 << d_) - 1;
    for (const int corner : brick)
      lines += fmt::format(",{}", id(grid_.corner(grid_.cell_at(cell), corner & in_grid), corner >> d_));
    lines += "\n";
  }
  for (const auto& [kind, lines] : of_kind)
    model_ += fmt::format("*ELEMENT, TYPE=C3D8, ELSET=KIND{}\n{}", kind, lines);
}

/// Ties copies of a layer to their original nodes.
void Deck::write_ties() {
  if (copies_ == 1)
    return;
  model_ += "*EQUATION\n";
  for (int copy = 1; copy < copies_; ++copy)
    for (const std::int64_t node : nodes_)
      for (int b = 1; b <= d_; ++b)
        model_ += fmt::format("2\n{},{},1.,{},{},-1.\n", id(node, copy), b, id(node, 0), b);
}

/// The 21 constants of *ELASTIC, TYPE=ANISO in its order, from a stiffness in Voigt order 11 22 33 23 13 12.
std::string anisotropic(const Matrix6& C) {
  constexpr int order[6] = {0, 1, 2, 5, 4, 3}; // 11 22 33 12 13 23
  std::string text = "*ELASTIC, TYPE=ANISO\n";
  int count = 0;
  for (int column = 0; column < 6; ++column)
    for (int row = 0; row <= column; ++row) {
      text += number(C(order[row], order[column]));
      ++count;
      text += count % 8 == 0 ? "\n" : ",";
    }
  return text + "293.\n";
}

/// A stiffness with the reduced one in the first `dimension` directions, and uncoupled others.
Matrix6 around(const Eigen::MatrixXd& reduced, int dimension) {
  Matrix6 C = reduced(0, 0) * Matrix6::Identity();
  if (dimension == 1)
    return C;
  constexpr int in_plane[3] = {0, 1, 5}; // xx yy xy
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      C(in_plane[i], in_plane[j]) = reduced(i, j);
  return C;
}

/// CalculiX's own laws: their volumetric energy is k/2 (J - 1)^2, and neo-Hookean shear is isochoric. @return
/// the card; empty for other laws
std::string hyperelastic(const Material& material) {
  const Law* const law = material.law ? &*material.law : nullptr;
  if (const auto* const neo = std::get_if<NeoHookean>(law))
    return fmt::format("*HYPERELASTIC, NEO HOOKE\n{},{}\n", number(neo->mu / 2),
                       number(2 / (neo->lambda + 2 * neo->mu / 3)));
  if (const auto* const mooney = std::get_if<MooneyRivlin>(law))
    return fmt::format("*HYPERELASTIC, MOONEY-RIVLIN\n{},{},{}\n", number(mooney->c1), number(mooney->c2),
                       number(2 / mooney->k));
  return {};
}

void Deck::write_materials() {
  const bool is_reduced = d_ == 1 || (d_ == 2 && scene_.plane == PlaneAssumption::stress);
  for (const auto& [kind, place] : kinds_) {
    const auto& [n, cell] = place;
    const ElasticConstants& c = scene_.materials[scene_.specimen.material(cell)].elasticity;
    std::string orientation;
    if (!is_reduced && !is_finite_ && !c.is_isotropic()) {
      const Eigen::Matrix3d axes = scene_.material_axes(cell);
      model_ += fmt::format("*ORIENTATION, NAME=AXES{}\n{},{},{},{},{},{}\n", n, number(axes(0, 0)),
                            number(axes(1, 0)), number(axes(2, 0)), number(axes(0, 1)), number(axes(1, 1)),
                            number(axes(2, 1)));
      orientation = fmt::format(", ORIENTATION=AXES{}", n);
    }
    model_ += fmt::format("*MATERIAL, NAME=MATTER{}\n", n);
    if (is_finite_)
      model_ += hyperelastic(scene_.materials[scene_.specimen.material(cell)]);
    else if (is_reduced)
      model_ += anisotropic(around(scene_.cell_stiffness(cell), d_));
    else if (c.is_isotropic())
      model_ += fmt::format("*ELASTIC\n{},{}\n", number(c.youngs_modulus[0]), number(c.nu12));
    else
      model_ += fmt::format("*ELASTIC, TYPE=ENGINEERING CONSTANTS\n{},{},{},{},{},{},{},{}\n{},293.\n",
                            number(c.youngs_modulus[0]), number(c.youngs_modulus[1]),
                            number(c.youngs_modulus[2]), number(c.nu12), number(c.nu13), number(c.nu23),
                            number(c.G12), number(c.G13), number(c.G23));
    model_ += fmt::format("*SOLID SECTION, ELSET=KIND{}, MATERIAL=MATTER{}{}\n", n, n, orientation);
  }
}

void Deck::write_conditions() {
  if (!scene_.prescribed.empty() || d_ < 3)
    step_ += "*BOUNDARY\n";
  for (int b = d_ + 1; b <= 3; ++b)
    step_ += fmt::format("ALL,{},{}\n", b, b);
  for (const Prescribed& p : scene_.prescribed)
    step_ += fmt::format("{},{},{},{}\n", id(p.node, 0), p.component + 1, p.component + 1, number(p.value));
}

void Deck::write_forces() {
  std::string lines;
  Scene dead = scene_;
  std::erase_if(dead.tractions, [&](const FaceLoad& load) { return is_finite_ && load.follows; });
  for (int b = 0; b < d_; ++b) {
    const List<double> forces = nodal_forces(dead, b);
    for (std::size_t node = 0; node < forces.size(); ++node)
      if (forces[node] != 0)
        lines +=
            fmt::format("{},{},{}\n", id(static_cast<std::int64_t>(node), 0), b + 1, number(forces[node]));
  }
  if (!lines.empty())
    step_ += "*CLOAD\n" + lines;
}

/// Pressures: with NLGEOM they stay normal to their faces, on the area that these have.
void Deck::write_pressures() {
  constexpr std::array<std::array<int, 2>, 3> faces{{{6, 4}, {3, 5}, {1, 2}}}; // of C3D8: lower, upper
  std::vector<std::int64_t> element;
  for (std::int64_t cell = 0, n = 0; cell < grid_.n_cells(); ++cell)
    element.push_back(scene_.specimen.is_matter(cell) ? ++n : 0);
  std::map<std::pair<std::int64_t, int>, double> pressures; // ccx uses only the last pressure of a face
  for (const FaceLoad& load : scene_.tractions)
    if (load.follows)
      pressures[{element[load.cell], faces[load.axis][load.upper ? 1 : 0]}] +=
          (load.upper ? -1 : 1) * load.traction[load.axis];
  step_ += pressures.empty() ? "" : "*DLOAD\n";
  for (const auto& [face, pressure] : pressures)
    step_ += fmt::format("{},P{},{}\n", face.first, face.second, number(pressure));
}

} // namespace

std::string why_no_deck(const Scene& scene) {
  if (scene.strain == Strain::finite) {
    if (scene.dimension() == 1 || (scene.dimension() == 2 && scene.plane == PlaneAssumption::stress))
      return "the deck has finite strain in 3D and in plane strain alone";
    if (scene.contracts())
      return "the deck has no fibres that contract at finite strain";
    for (const Material& material : scene.materials)
      if (hyperelastic(material).empty())
        return fmt::format(
            "of the laws of finite strain CalculiX has neo_hookean and mooney_rivlin: {} has {}",
            material.name, material.law ? name_of(*material.law) : "none");
  }
  if (scene.specimen.has_weights())
    return "cells that are tissue in part, or of a map of stiffness, are no material of the deck";
  if (!scene.springs.empty())
    return "the deck has no springs to the ground";
  return scene.sliding.empty() ? "" : "the deck has no borders that slide";
}

std::string calculix_deck(const Scene& scene) {
  return Deck(scene).text();
}

} // namespace maille::studies
