#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

namespace maille::lab {

namespace {

constexpr const char* in_a_file = "NaN and infinity in a scene file";
constexpr const char* in_a_program = "NaN and infinity in a Scene of a program";

/// A numeric field of a scene file: the text with `@` in its place.
struct Field {
  const char* name;
  Question question;
};

std::vector<Field> fields_of_a_file() {
  const std::string pull = clamped("[0.0001, 0, 0]");
  const auto with_matter = [&](const char* matter) {
    return Question{.material = matter, .conditions = pull};
  };
  const auto with_conditions = [](const std::string& text) {
    return Question{.conditions = "[[hold]]\nwhere = \"x-\"\n" + text};
  };
  const auto with_limits = [&](const char* text) { return Question{.limits = text, .conditions = pull}; };
  return {
      {"specimen.cells", {.cells = "[@, 8, 8]", .conditions = pull}},
      {"specimen.spacing", {.spacing = "@", .conditions = pull}},
      {"specimen.spacing, of an axis", {.spacing = "[0.001, @, 0.001]", .conditions = pull}},
      {"youngs_modulus", with_matter("{ youngs_modulus = @, poisson_ratio = 0.3 }")},
      {"poisson_ratio", with_matter("{ youngs_modulus = 1000, poisson_ratio = @ }")},
      {"density", with_matter("{ youngs_modulus = 1000, poisson_ratio = 0.3, density = @ }")},
      {"relaxed_weights", with_matter("{ youngs_modulus = 1000, poisson_ratio = 0.3, relaxed_weights = @ }")},
      {"stretch of a material",
       with_matter(
           "{ youngs_modulus = 1000, poisson_ratio = 0.3, stretch = @, compress = 0.8, shear = 0.1 }")},
      {"E_fibre",
       with_matter("{ E_fibre = @, E_cross = 1000, G_fibre = 400, nu_fibre = 0.3, nu_cross = 0.3 }")},
      {"E_cross",
       with_matter("{ E_fibre = 1000, E_cross = @, G_fibre = 400, nu_fibre = 0.3, nu_cross = 0.3 }")},
      {"G_fibre",
       with_matter("{ E_fibre = 1000, E_cross = 1000, G_fibre = @, nu_fibre = 0.3, nu_cross = 0.3 }")},
      {"nu_fibre",
       with_matter("{ E_fibre = 1000, E_cross = 1000, G_fibre = 400, nu_fibre = @, nu_cross = 0.3 }")},
      {"nu_cross",
       with_matter("{ E_fibre = 1000, E_cross = 1000, G_fibre = 400, nu_fibre = 0.3, nu_cross = @ }")},
      {"E", with_matter("{ E = [1000, @, 1000], nu = [0.3, 0.3, 0.3], G = [400, 400, 400] }")},
      {"nu", with_matter("{ E = [1000, 1000, 1000], nu = [0.3, @, 0.3], G = [400, 400, 400] }")},
      {"G", with_matter("{ E = [1000, 1000, 1000], nu = [0.3, 0.3, 0.3], G = [400, 400, @] }")},
      {"specimen.fibre", {.fibre = "[1, @, 0]", .conditions = pull}},
      {"specimen.fibre.angle", {.fibre = "{ angle = @, plane = \"xz\" }", .conditions = pull}},
      {"specimen.fibre.bipennate",
       {.fibre = "{ angle = 0.3, plane = \"xz\", bipennate = @ }", .conditions = pull}},
      {"specimen.fibre.curve", {.fibre = "{ curve = [[0, 0, 0], [0.001, @, 0]] }", .conditions = pull}},
      {"hold.where", {.conditions = "[[hold]]\nwhere = { box = [[0, 0, 0], [@, 1, 1]] }\n"}},
      {"move.where", with_conditions("[[move]]\nwhere = { box = [[@, 0, 0], [1, 1, 1]] }\nby = [0, 0, 0]\n")},
      {"move.by", with_conditions("[[move]]\nwhere = \"x+\"\nby = [@, 0, 0]\n")},
      {"move.turn.angle",
       with_conditions("[[move]]\nwhere = \"x+\"\nturn = { angle = @, axis = [0, 0, 1] }\n")},
      {"move.turn.axis",
       with_conditions("[[move]]\nwhere = \"x+\"\nturn = { angle = 0.1, axis = [0, @, 1] }\n")},
      {"move.turn.about",
       with_conditions(
           "[[move]]\nwhere = \"x+\"\nturn = { angle = 0.1, axis = [0, 0, 1], about = [0, @, 0] }\n")},
      {"load.traction", with_conditions("[[load]]\nwhere = \"x+\"\ntraction = [@, 0, 0]\n")},
      {"load.gravity", with_conditions("[[load]]\ngravity = [0, 0, @]\n")},
      {"load.contraction", with_conditions("[[load]]\ncontraction = @\n")},
      {"limits.stretch", with_limits("from = \"given\"\nstretch = @\ncompress = 0.8\nshear = 0.1\n")},
      {"limits.compress", with_limits("from = \"given\"\nstretch = 1.2\ncompress = @\nshear = 0.1\n")},
      {"limits.shear", with_limits("from = \"given\"\nstretch = 1.2\ncompress = 0.8\nshear = @\n")},
      {"limits.shear, of an axis",
       with_limits(
           "from = \"given\"\nstretch = 1.2\ncompress = 0.8\nshear = [[0, @, 0], [0, 0, 0], [0, 0, 0]]\n")},
      {"relaxation.tolerance", {.conditions = pull, .relaxation = "tolerance = @\n"}},
      {"relaxation.sweeps", {.conditions = pull, .relaxation = "sweeps = @\n"}},
      {"relaxation.increments", {.conditions = pull, .relaxation = "increments = @\n"}},
  };
}

/// The reader must have a fault for every such value. @return the first fault, or what was let through in
/// `broken`
StabilityCell read(const Field& field) {
  StabilityCell cell;
  cell.outcome = "refused";
  for (const char* value : {"nan", "inf", "-inf", "\"nan\"", "\"inf\"", "\"-infinity\"", "\"1e999\""}) {
    std::string text = field.question.text();
    text.replace(text.find('@'), 1, value);
    try {
      parse_scene(text, "extreme.toml");
      cell.broken = fmt::format("the reader takes {}", value);
      cell.outcome = "accepted";
    } catch (const InputError& error) {
      if (cell.note.empty())
        cell.note = to_string(error.faults().at(0));
    }
  }
  return cell;
}

/// A numeric field of a Scene.
struct Member {
  const char* name;
  void (*set)(Scene& scene, double value);
};

constexpr std::array members{
    Member{"spacing",
           [](Scene& s, double v) {
             s.specimen.grid = Grid(3, s.specimen.grid.cells(), {1e-3, v, 1e-3});
           }},
    Member{"origin", [](Scene& s, double v) { s.specimen.origin[1] = v; }},
    Member{"fibre",
           [](Scene& s, double v) {
             s.specimen.fibre = {v, 1, 0};
           }},
    Member{"fibre of a cell",
           [](Scene& s, double v) {
             s.specimen.fibres.assign(static_cast<std::size_t>(s.specimen.grid.n_cells()), {1, 0, 0});
             s.specimen.fibres[3][1] = static_cast<float>(v);
           }},
    Member{"Young's modulus", [](Scene& s, double v) { s.materials[0].elasticity.youngs_modulus[1] = v; }},
    Member{"Poisson ratio", [](Scene& s, double v) { s.materials[0].elasticity.nu23 = v; }},
    Member{"shear modulus", [](Scene& s, double v) { s.materials[0].elasticity.G13 = v; }},
    Member{"density", [](Scene& s, double v) { s.materials[0].density = v; }},
    Member{"weight of relaxed", [](Scene& s, double v) { s.materials[0].relaxed_weights[2] = v; }},
    Member{"limits of a material",
           [](Scene& s, double v) {
             s.limits.from = LimitSource::material;
             s.materials[0].limits = NeighbourLimits{};
             s.materials[0].limits->shear[0][1] = v;
           }},
    Member{"given limits",
           [](Scene& s, double v) {
             s.limits.from = LimitSource::given;
             s.limits.given.stretch[1] = v;
           }},
    Member{"scale of taut limits", [](Scene& s, double v) { s.limits.taut_scale = v; }},
    Member{"prescribed displacement", [](Scene& s, double v) { s.prescribed.back().value = v; }},
    Member{"gravity", [](Scene& s, double v) { s.gravity[2] = v; }},
    Member{"traction",
           [](Scene& s, double v) {
             s.tractions.push_back({0, 0, false, {v, 0, 0}});
           }},
    Member{"active stress",
           [](Scene& s, double v) {
             s.active_stress.assign(static_cast<std::size_t>(s.specimen.grid.n_cells()), 0);
             s.active_stress[5] = v;
           }},
    Member{"tolerance", [](Scene& s, double v) { s.relaxation.tolerance = v; }},
};

StabilityCell solve_with(const Member& member, Methods& methods, const std::string& method,
                         const Control& control) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  StabilityCell cell;
  cell.outcome = "refused";
  for (const double value : {std::nan(""), infinity, -infinity}) {
    Scene scene = Question{.cells = "[4, 4, 4]", .conditions = clamped("[0.0001, 0, 0]")}.scene();
    member.set(scene, value);
    const Answer answer = methods.answer(scene, method, control);
    if (answer.status != Status::refused || answer.message.empty())
      cell.broken = fmt::format("{} is answered: {}", value, to_string(answer.status));
    if (cell.note.empty())
      cell.note = answer.message;
  }
  if (!cell.broken.empty())
    cell.outcome = "accepted";
  return cell;
}

} // namespace

void add_numbers_that_are_none(std::vector<Extreme>& list) {
  for (const Field& field : fields_of_a_file())
    list.push_back({.extreme = in_a_file,
                    .setting = field.name,
                    .scene = {},
                    .methods = {"(reader)"},
                    .protocol = [=](Methods&, const std::string&, const Control&) { return read(field); }});
  for (const Member& member : members)
    list.push_back({.extreme = in_a_program,
                    .setting = member.name,
                    .scene = {},
                    .protocol = [=](Methods& methods, const std::string& method, const Control& control) {
                      return solve_with(member, methods, method, control);
                    }});
}

} // namespace maille::lab
