// Answers: arrays that are views of their memory, and tables of records.

#include "binding.hpp"
#include "maille/deform/estimated_error.hpp"
#include "maille/deform/solve.hpp"
#include "maille/mechanics/recovery.hpp"
#include "maille/scene/plausibility.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <type_traits>

namespace maille::python {

namespace {

using Tensors = std::vector<std::array<double, 6>>;

void require_displacement(const AnswerHandle& handle) {
  if (!handle.has_displacement())
    throw py::value_error("the answer has no displacement: " + handle.answer.message);
}

/// What was found before, or is found now in a thread of its own.
template<class T, class Make>
const T& found_once(std::optional<T>& found, const py::object& self, Make make) {
  if (!found)
    if (T made = made_in_thread(std::move(make), self); !found) // another thread may have been first
      found = std::move(made);
  return *found;
}

const CellFields& fields_of(const py::object& self) {
  auto& handle = self.cast<AnswerHandle&>();
  require_displacement(handle);
  return found_once(handle.fields, self, [&handle] { return cell_fields(handle.scene(), handle.answer); });
}

/// One value a cell, or six.
py::array cells_view(py::handle owner, const Grid& grid, const double* data, py::ssize_t components) {
  std::vector<py::ssize_t> shape = shape_of(grid, grid.cells()), strides;
  const Index3& n = grid.cells();
  const py::ssize_t number = static_cast<py::ssize_t>(sizeof(double)) * components;
  for (int axis = grid.dimension(); axis-- > 0;)
    strides.push_back(number * (axis == 0 ? 1 : axis == 1 ? n[0] : py::ssize_t{n[0]} * n[1]));
  if (components > 1) {
    shape.push_back(components);
    strides.push_back(sizeof(double));
  }
  return view_of(owner, data, std::move(shape), std::move(strides));
}

py::array tensors(const py::object& self, const Tensors CellFields::*of) {
  const Tensors& values = fields_of(self).*of;
  return cells_view(self, self.cast<const AnswerHandle&>().scene().specimen.grid, values.front().data(), 6);
}

void add_spread(py::dict& record, const std::string& name, const std::optional<Spread>& spread) {
  if (!spread)
    return;
  const std::pair<const char*, double> figures[] = {{"mean", spread->mean},  {"min", spread->least},
                                                    {"max", spread->most},   {"p5", spread->percentile_5},
                                                    {"p50", spread->median}, {"p95", spread->percentile_95}};
  for (const auto& [key, value] : figures)
    record[py::str(name + "_" + key)] = value;
}

py::dict record_of(const PartMechanics& part) {
  py::dict record;
  if (part.label)
    record["label"] = *part.label;
  if (!part.material.empty())
    record["material"] = part.material;
  record["cells"] = part.cells;
  record["volume_at_rest"] = part.volume_at_rest;
  record["volume"] = part.volume;
  record["volume_change"] = part.volume_change();
  add_spread(record, "fibre_strain", part.fibre_strain);
  add_spread(record, "largest_strain", part.largest_strain);
  add_spread(record, "smallest_strain", part.smallest_strain);
  add_spread(record, "fibre_stress", part.fibre_stress);
  add_spread(record, "von_mises", part.von_mises);
  add_spread(record, "pressure", part.pressure);
  if (part.strain_energy)
    record["strain_energy"] = *part.strain_energy;
  return record;
}

py::dict record_of(const Resultant& resultant) {
  py::dict record;
  record["name"] = resultant.name;
  record["where"] = resultant.where;
  record["centroid"] = resultant.centroid;
  record["force"] = resultant.force;
  record["moment"] = resultant.moment;
  return record;
}

template<class Rows>
py::list records_of(const Rows& rows) {
  py::list list;
  for (const auto& row : rows)
    list.append(record_of(row));
  return list;
}

std::vector<double> energies_of_cells(const AnswerHandle& handle) {
  return has_stress(handle.answer.method) ? deform::cell_energies(handle.scene(), handle.answer)
                                          : std::vector<double>{};
}

const Mechanics& found_mechanics(const py::object& self) {
  auto& handle = self.cast<AnswerHandle&>();
  return found_once(handle.found, self, [&handle] {
    return mechanics_of(handle.scene(), handle.answer, energies_of_cells(handle));
  });
}

/// As the command has them: of the question, and of the answer.
std::vector<std::string> warnings(const py::object& self) {
  const auto& handle = self.cast<const AnswerHandle&>();
  const Scene& scene = handle.scene();
  const Plausibility question = plausibility(scene);
  std::vector<std::string> found = question.warnings;
  std::ranges::move(unused_settings(scene, {handle.answer.method}), std::back_inserter(found));
  if (!handle.has_displacement() || !has_stress(handle.answer.method))
    return found;
  double largest = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 u = handle.answer.displacement.at(node);
    largest = std::max(largest, std::hypot(u[0], u[1], u[2]));
  }
  for (std::string& warning :
       implausible_answer(scene, question, handle.answer.method, largest, found_mechanics(self).body))
    found.push_back(std::move(warning));
  return found;
}

py::dict mechanics(const py::object& self) {
  require_displacement(self.cast<const AnswerHandle&>());
  const Mechanics& found = found_mechanics(self);
  py::dict out;
  out["holds"] = records_of(found.holds);
  out["moves"] = records_of(found.moves);
  out["loads"] = records_of(found.loads);
  out["labels"] = records_of(found.labels);
  out["materials"] = records_of(found.materials);
  out["body"] = record_of(found.body);
  return out;
}

py::list measures(const py::object& self) {
  const auto& handle = self.cast<const AnswerHandle&>();
  require_displacement(handle);
  const std::vector<MeasuredValue> found = made_in_thread(
      [&handle] {
        return measured(handle.scene(), handle.asked->measures, handle.answer, energies_of_cells(handle));
      },
      self);
  py::list list;
  for (const MeasuredValue& value : found) {
    py::dict record;
    record["name"] = value.name;
    record["unit"] = value.unit;
    record["value"] = value.value;
    record["vector"] = value.vector;
    record["why_not"] = value.why_not;
    py::list line;
    for (const LinePoint& point : value.line)
      line.append(py::make_tuple(point.along, point.place, point.value, point.vector));
    record["line"] = line;
    list.append(record);
  }
  return list;
}

py::dict compared(const py::object& self, const py::object& other) {
  const auto &handle = self.cast<const AnswerHandle&>(), &reference = other.cast<const AnswerHandle&>();
  require_displacement(handle);
  require_displacement(reference);
  const Grid &ours = handle.scene().specimen.grid, &theirs = reference.scene().specimen.grid;
  if (ours.nodes() != theirs.nodes() || ours.spacing() != theirs.spacing())
    throw py::value_error("expected answers on the same grid");
  const auto [norms, errors] = made_in_thread(
      [&] {
        return std::pair(
            maille::compare(handle.scene(), handle.answer.displacement, reference.answer.displacement),
            compare_mechanics(handle.scene(), handle.answer, reference.answer));
      },
      py::make_tuple(self, other));
  py::dict out;
  out["relative_l2"] = norms.relative_l2;
  out["relative_max"] = norms.relative_max;
  out["rms"] = norms.rms;
  out["force"] = errors.force;
  out["strain_energy"] = errors.strain_energy;
  out["strain"] = errors.strain;
  out["stress"] = errors.stress;
  return out;
}

py::dict estimate(const AnswerHandle& handle, int threads, py::object progress) {
  require_displacement(handle);
  Steering steering(threads, {}, {}, std::move(progress));
  deform::ErrorEstimation found;
  {
    const py::gil_scoped_release unlocked;
    found = deform::estimate_error(handle.scene(), handle.answer, steering.control());
  }
  steering.finish();
  py::dict out;
  out["reason"] = found.reason;
  if (!found.estimate)
    return out;
  out["relative_l2"] = found.estimate->norms.relative_l2;
  out["relative_max"] = found.estimate->norms.relative_max;
  out["rms"] = found.estimate->norms.rms;
  out["force"] = found.estimate->mechanics.force;
  out["strain_energy"] = found.estimate->mechanics.strain_energy;
  out["strain"] = found.estimate->mechanics.strain;
  out["stress"] = found.estimate->mechanics.stress;
  return out;
}

// Pickles: everything that an answer has but its scene, which is asked anew for the rest.

py::bytes packed(const void* data, std::size_t bytes) {
  return py::bytes(static_cast<const char*>(data), bytes);
}

/// @throws ValueError where the bytes are no whole values
template<class Values>
Values unpacked(const py::handle& packed) {
  using Value = typename Values::value_type;
  static_assert(std::is_trivially_copyable_v<Value>);
  const auto text = packed.cast<std::string_view>();
  if (text.size() % sizeof(Value) != 0)
    throw py::value_error("expected an answer's state, found one of other values");
  Values values(text.size() / sizeof(Value));
  std::memcpy(values.data(), text.data(), text.size());
  return values;
}

/// Calls `visit` with each list of an answer but its displacement.
void each_list(auto& answer, const auto& visit) {
  visit(answer.reaction);
  visit(answer.cell_energy);
  visit(answer.cell_strain);
  visit(answer.split);
  visit(answer.tie_press);
  visit(answer.rubbing);
  visit(answer.nodal_strain);
  visit(answer.nodal_stress);
}

py::tuple state_of(const AnswerHandle& handle) {
  const Answer& a = handle.answer;
  py::list lists;
  each_list(a, [&](const auto& list) { lists.append(packed(list.data(), list.size() * sizeof(list[0]))); });
  const auto u = a.displacement.values();
  return py::make_tuple(handle.scene().relaxation.tolerance, a.method, a.algorithm,
                        static_cast<int>(a.status), a.message, a.displacement.n_components(),
                        packed(u.data(), u.size_bytes()), a.n_cut, a.iterations, a.residual, a.seconds.setup,
                        a.seconds.solve, a.strain_energy, a.extrapolated, a.bytes, lists);
}

/// @param handle the scene that was answered, scaled to the answer's step
/// @throws ValueError where the state is of another body
AnswerHandle answer_of(const SceneHandle& handle, const py::tuple& state) {
  AnswerHandle made{handle.asked, {}};
  std::size_t i = 0;
  const auto next = [&]<class T>(T& value) { value = state[i++].cast<T>(); };
  Answer& a = made.answer;
  int status = 0;
  std::size_t n_components = 0;
  double tolerance = 0;
  next(tolerance);
  if (tolerance != handle.scene().relaxation.tolerance) {
    auto asked = std::make_shared<SceneAndMeasures>(*handle.asked);
    asked->scene.relaxation.tolerance = tolerance;
    made.asked = std::move(asked);
  }
  next(a.method);
  next(a.algorithm);
  next(status);
  a.status = static_cast<Status>(std::clamp(status, 0, static_cast<int>(Status::failed)));
  next(a.message);
  next(n_components);
  const auto u = unpacked<std::vector<double>>(state[i++]);
  const std::size_t n_nodes = made.scene().specimen.grid.n_nodes();
  if (!u.empty() && (n_components != static_cast<std::size_t>(made.scene().dimension()) ||
                     u.size() != n_components * n_nodes))
    throw py::value_error("expected the scene that was answered, found one of another grid");
  if (!u.empty()) {
    a.displacement = Displacement(n_components, n_nodes);
    std::ranges::copy(u, a.displacement.values().begin());
  }
  next(a.n_cut);
  next(a.iterations);
  next(a.residual);
  next(a.seconds.setup);
  next(a.seconds.solve);
  next(a.strain_energy);
  next(a.extrapolated);
  next(a.bytes);
  const auto lists = state[i].cast<py::list>();
  std::size_t number = 0;
  each_list(a, [&](auto& list) { list = unpacked<std::decay_t<decltype(list)>>(lists[number++]); });
  return made;
}

} // namespace

void bind_answers(py::module_& module) {
  using Handle = AnswerHandle;
  module.def("compare", &compared);
  module.def("answer_of", &answer_of);
  py::class_<Handle>(module, "Answer")
      .def_property_readonly("method", [](const Handle& a) { return a.answer.method; })
      .def_property_readonly("algorithm", [](const Handle& a) { return a.answer.algorithm; })
      .def_property_readonly("status",
                             [](const Handle& a) { return std::string(to_string(a.answer.status)); })
      .def_property_readonly("is_converged", [](const Handle& a) { return is_converged(a.answer.status); })
      .def_property_readonly("message", [](const Handle& a) { return a.answer.message; })
      .def_property_readonly("n_cut", [](const Handle& a) { return a.answer.n_cut; })
      .def_property_readonly("iterations", [](const Handle& a) { return a.answer.iterations; })
      .def_property_readonly("residual", [](const Handle& a) { return a.answer.residual; })
      .def_property_readonly("setup_seconds", [](const Handle& a) { return a.answer.seconds.setup; })
      .def_property_readonly("seconds", [](const Handle& a) { return a.answer.seconds.total(); })
      .def_property_readonly("bytes", [](const Handle& a) { return a.answer.bytes; })
      .def_property_readonly("strain_energy", [](const Handle& a) { return a.answer.strain_energy; })
      .def_property_readonly("has_displacement", &Handle::has_displacement)
      .def_property_readonly("scene", [](const Handle& a) { return SceneHandle{a.asked}; })
      .def_property_readonly("displacement",
                             [](const py::object& self) {
                               const auto& handle = self.cast<const Handle&>();
                               require_displacement(handle);
                               return displacement_view(self, handle.scene().specimen.grid,
                                                        handle.answer.displacement);
                             })
      .def_property_readonly("strain",
                             [](const py::object& self) { return tensors(self, &CellFields::strain); })
      .def_property_readonly("stress",
                             [](const py::object& self) { return tensors(self, &CellFields::stress); })
      .def_property_readonly("von_mises",
                             [](const py::object& self) {
                               const Grid& grid = self.cast<const Handle&>().scene().specimen.grid;
                               return cells_view(self, grid, fields_of(self).von_mises.data(), 1);
                             })
      .def_property_readonly("has_stress", [](const Handle& a) { return has_stress(a.answer.method); })
      .def("state", &state_of)
      .def("warnings", &warnings)
      .def("mechanics", &mechanics)
      .def("measures", &measures)
      .def("estimate", &estimate);
}

} // namespace maille::python
