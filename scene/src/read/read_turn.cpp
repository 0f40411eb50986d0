#include "read/reader.hpp"

#include <fmt/format.h>

#include <cmath>

namespace maille::reader {

namespace {

/// A direction of three plain numbers; nothing and a fault for other values.
std::optional<Vec3> read_direction(TableReader& table, std::string_view key) {
  const auto v = table.quantities(key, Dimension::dimensionless, false);
  if (!v)
    return std::nullopt;
  const double length = std::hypot((*v)[0], (*v)[1], (*v)[2]);
  if (!(length > 0) || !std::isfinite(length)) {
    table.fault(key, "a direction that is not zero", describe(*table.find(key)));
    return std::nullopt;
  }
  return Vec3{(*v)[0] / length, (*v)[1] / length, (*v)[2] / length};
}

} // namespace

std::optional<Turn> read_turn(TableReader& table, int dimension, bool& turns_about_its_middle) {
  const toml::table* values = table.subtable("turn");
  if (!values)
    return std::nullopt;
  if (dimension == 1) {
    table.fault("turn", "a scene of two or three dimensions: a line has nothing to turn", "one dimension");
    return std::nullopt;
  }
  TableReader reader(*values, table.path_of("turn"), table.faults());
  Turn turn;
  bool is_good = true;
  if (!reader.require("angle", "an angle"))
    is_good = false;
  else if (const auto angle = reader.quantity("angle", Dimension::angle);
           angle && std::abs(*angle) > largest_turn) {
    reader.fault("angle", "at most a hundred full turns", describe(*reader.find("angle")));
    is_good = false;
  } else if (angle)
    turn.angle = *angle;
  else
    is_good = false;
  if (dimension == 2 && reader.has("axis")) {
    reader.find("axis");
    reader.fault("axis", "no axis: a plane turns in itself", describe(*reader.find("axis")));
    is_good = false;
  } else if (dimension != 2 && reader.require("axis", "a direction, like [0, 0, 1]")) {
    const auto axis = read_direction(reader, "axis");
    is_good = is_good && axis;
    turn.axis = axis.value_or(turn.axis);
  }
  turns_about_its_middle = !reader.has("about");
  if (!turns_about_its_middle) {
    const auto about = reader.quantities("about", Dimension::length, false);
    is_good = is_good && about;
    turn.about = about.value_or(turn.about);
  }
  reader.finish();
  return is_good && reader.has("angle") ? std::optional(turn) : std::nullopt;
}

} // namespace maille::reader
