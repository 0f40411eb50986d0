#include "checks/promises.hpp"
#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include "checks/random_scene.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::lab {

namespace {

constexpr double h = 1e-3;

/// A cube of 4 x 4 x 4 cells, held below, two of its nodes moved; of one matter, or of two with a hole.
Scene small_body(const std::string& limits, bool is_mixed) {
  Scene scene = Question{.cells = "[4, 4, 4]",
                         .limits = limits,
                         .conditions = "[[hold]]\nwhere = \"z-\"\n" + moved_node({0, 0, 4 * h}, {0, 0, 0}) +
                                       moved_node({4 * h, 3 * h, 4 * h}, {0, 0, 0})}
                    .scene();
  if (is_mixed) {
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].elasticity = ElasticConstants::isotropic(1e6, 0.4);
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
      scene.specimen.material_id.push_back(static_cast<std::uint8_t>(cell % 2));
    scene.specimen.material_id[21] = no_material;
  }
  return scene;
}

/// Counts what answers of a story say.
class Story {
public:
  Story(const Scene& scene, const std::string& method) : limits_(scene), method_(method) {}

  /// @return whether it is worth going on
  bool add(const Scene& scene, const Answer& answer) {
    cell_.iterations += answer.iterations;
    cell_.outcome = is_converged(answer.status)               ? "settled"
                    : answer.status == Status::budget_reached ? "budget reached"
                                                              : std::string(to_string(answer.status));
    n_clamped_ += answer.status == Status::clamped ? 1 : 0;
    ++n_;
    cell_.broken = broken_promise(scene, method_, answer);
    if (!cell_.broken.empty())
      cell_.broken = fmt::format("at step {}: {}", n_, cell_.broken);
    if (!has_displacement(answer.status)) {
      cell_.note = answer.message;
      return false;
    }
    cell_.violation = std::max(cell_.violation.value_or(0),
                               largest_violation(scene, limits_, answer.displacement, object_frame(scene)));
    return cell_.broken.empty();
  }
  StabilityCell take() {
    if (cell_.note.empty())
      cell_.note = fmt::format("{} steps, {} of them cut back", n_, n_clamped_);
    return cell_;
  }
  StabilityCell& cell() { return cell_; }

private:
  LinkLimits limits_;
  std::string method_;
  StabilityCell cell_;
  std::int64_t n_ = 0, n_clamped_ = 0;
};

void set_moves(Scene& scene, const std::function<double(const Prescribed&)>& value) {
  for (Prescribed& p : scene.prescribed)
    if (!p.held)
      p.value = value(p);
}

/// Continues from the end of the last drag. Drags store float32, which limits the accuracy of links.
StabilityCell drag_on(Scene scene, int drags) {
  const LinkLimits limits(scene);
  deform::Drag drag(scene, limits);
  std::vector<std::int64_t> handles;
  for (const Prescribed& p : scene.prescribed)
    if (!p.held && p.component == 0)
      handles.push_back(p.node);
  Choices choices(1);
  StabilityCell cell;
  cell.outcome = "settled";
  cell.violation = 0;
  int n_cut = 0;
  for (int i = 0; i < drags && cell.broken.empty(); ++i) {
    Vec3 by{};
    for (double& component : by)
      component = h * (2 - 4 * choices.uniform());
    const auto step = drag.move_to(handles[static_cast<std::size_t>(i % 2)], by);
    n_cut += step.is_cut ? 1 : 0;
    cell.iterations += step.visited;
    const Displacement u = drag.displacement();
    const Excess found = excess(scene, limits, u);
    constexpr double float32 = 0x1p-22; // two roundings of what is stored
    if (!(found.largest <= found.allowed + float32 * 4 * h))
      cell.broken = fmt::format("at step {} a link is {} m outside its limits", i + 1, found.largest);
    cell.violation = std::max(*cell.violation, largest_violation(scene, limits, u, drag.frame()));
  }
  cell.note = fmt::format("from where the last drag ended; {} of {} cut back", n_cut, drags);
  return cell;
}

StabilityCell drags_in_a_row(const Scene& start, int drags, Methods& methods, const std::string& method,
                             const Control& control) {
  if (method == "limits")
    return drag_on(start, drags);
  Scene scene = start;
  Story story(scene, method);
  Choices choices(1);
  for (int i = 0; i < drags; ++i) {
    set_moves(scene, [&](const Prescribed&) { return h * (2 - 4 * choices.uniform()); });
    if (!story.add(scene, methods.answer(scene, method, control)))
      break;
  }
  return story.take();
}

/// The largest difference of two states over the largest displacement of the first.
double drift(const Displacement& first, const Displacement& now) {
  double largest = 0, difference = 0;
  for (std::size_t i = 0; i < first.values().size(); ++i) {
    largest = std::max(largest, std::abs(first.values()[i]));
    difference = std::max(difference, std::abs(now.values()[i] - first.values()[i]));
  }
  return largest > 0 ? difference / largest : difference;
}

/// Out, back, to the other side, back: `cycles` times. What is compared is the state at the first of these
/// four.
StabilityCell cycles_of(const Scene& start, double reach, int cycles, Methods& methods,
                        const std::string& method, const Control& control) {
  Scene scene = start;
  Story story(scene, method);
  std::optional<Displacement> first;
  double largest_drift = 0;
  for (int i = 0; i < cycles; ++i)
    for (const double side : {1.0, 0.0, -1.0, 0.0}) {
      set_moves(scene, [&](const Prescribed& p) { return side * reach * (p.component + 1) / 3; });
      const Answer answer = methods.answer(scene, method, control);
      if (!story.add(scene, answer))
        return story.take();
      if (side != 1)
        continue;
      if (!first)
        first = answer.displacement;
      largest_drift = std::max(largest_drift, drift(*first, answer.displacement));
    }
  story.cell().error = largest_drift;
  return story.take();
}

/// The same by one hand that never lets go: neighbour limits alone are plastic.
StabilityCell cycles_of_a_drag(const Scene& scene, double reach, int cycles) {
  const LinkLimits limits(scene);
  deform::Drag drag(scene, limits);
  std::vector<deform::Drag::Move> moves;
  for (const Prescribed& p : scene.prescribed)
    if (!p.held && p.component == 0)
      moves.push_back({p.node, {}});
  StabilityCell cell;
  cell.outcome = "settled";
  std::optional<Displacement> first;
  double largest_drift = 0;
  for (int i = 0; i < cycles; ++i)
    for (const double side : {1.0, 0.0, -1.0, 0.0}) {
      for (auto& move : moves)
        move.displacement = {side * reach / 3, side * reach * 2 / 3, side * reach};
      cell.iterations += drag.move_to(moves).visited;
      if (side != 1)
        continue;
      if (i == 1) // the first way out is from rest, later ones are from where the way back has left the body
        first = drag.displacement();
      if (first)
        largest_drift = std::max(largest_drift, drift(*first, drag.displacement()));
    }
  cell.violation = largest_violation(scene, limits, drag.displacement(), drag.frame());
  cell.error = largest_drift;
  cell.note = fmt::format("one drag; after the last way back nodes are up to {:.3g} spacings from rest",
                          drag.residue().largest / h);
  return cell;
}

} // namespace

void add_long_stories(std::vector<Extreme>& list, const ExtremeSizes& sizes) {
  const std::string wide = given_limits(1.5, 0.5, 0.5), narrow = given_limits(1.1, 0.9, 0.1);
  const auto add_drags = [&](const char* body, const std::string& limits, bool is_mixed) {
    list.push_back({.extreme = "random drags in a row",
                    .setting = fmt::format("{}, {}", sizes.drags, body),
                    .scene = {},
                    .protocol = [=](Methods& methods, const std::string& method, const Control& control) {
                      return drags_in_a_row(small_body(limits, is_mixed), sizes.drags, methods, method,
                                            control);
                    }});
  };
  add_drags("one matter, wide limits", wide, false);
  add_drags("two kinds of matter with a hole, wide limits", wide, true);

  const auto add_cycles = [&](const char* setting, const std::string& limits, double reach) {
    list.push_back({.extreme = "cyclic loading",
                    .setting = fmt::format("{} times, {}", sizes.cycles, setting),
                    .scene = {},
                    .protocol = [=](Methods& methods, const std::string& method, const Control& control) {
                      const Scene scene = small_body(limits, false);
                      return method == "limits"
                                 ? cycles_of_a_drag(scene, reach, sizes.cycles)
                                 : cycles_of(scene, reach, sizes.cycles, methods, method, control);
                    }});
  };
  add_cycles("within the limits", wide, 0.2 * h);
  add_cycles("limits are active", narrow, 0.6 * h);
}

} // namespace maille::lab
