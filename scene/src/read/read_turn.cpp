#include "read/reader.hpp"

#include <fmt/format.h>

#include <cmath>

namespace maille::reader {

namespace {

/// A direction of three plain numbers; nothing and a fault for other values.
std::optional<Vec3> read_direction(TableReader& table, std::string_view key) {
  const auto v = table.three(key);
  if (!v)
    return std::nullopt;
  const double length = std::hypot((*v)[0], (*v)[1], (*v)[2]);
  if (length > 0 && std::isfinite(length))
    return Vec3{(*v)[0] / length, (*v)[1] / length, (*v)[2] / length};
  table.fault(key, "a direction that is not zero");
  return std::nullopt;
}

} // namespace

std::optional<Turn> read_turn(TableReader& table, int dimension, bool& turns_about_its_middle) {
  auto reader = table.open("turn");
  if (!reader)
    return std::nullopt;
  if (dimension == 1) {
    table.fault("turn", "a scene of two or three dimensions: a line has nothing to turn", "one dimension");
    return std::nullopt;
  }
  Turn turn;
  const auto angle = reader->number("angle");
  bool is_good = angle.has_value();
  turn.angle = angle.value_or(0);
  if (std::abs(turn.angle) > largest_turn) {
    reader->fault("angle", "at most a hundred full turns");
    is_good = false;
  }
  if (dimension == 2 && reader->has("axis")) {
    reader->fault("axis", "no axis: a plane turns in itself");
    is_good = false;
  } else if (dimension != 2 && reader->require("axis")) {
    const auto axis = read_direction(*reader, "axis");
    is_good = is_good && axis;
    turn.axis = axis.value_or(turn.axis);
  }
  turns_about_its_middle = !reader->has("about");
  if (!turns_about_its_middle) {
    const auto about = reader->three("about");
    is_good = is_good && about;
    turn.about = about.value_or(turn.about);
  }
  reader->finish();
  return is_good ? std::optional(turn) : std::nullopt;
}

} // namespace maille::reader
