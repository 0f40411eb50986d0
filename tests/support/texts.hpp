#pragma once
/// Texts: scene files in pieces (boxes of cells of 1 mm, their conditions, worlds of boxes), and what a
/// message has.

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace maille::test {

inline const std::string soft = R"({ youngs_modulus = "10 kPa", poisson_ratio = 0.3 })";

/// @param cells, material  as a scene has them
inline std::string box_text(const std::string& cells, const std::string& material = soft) {
  return "[specimen]\nshape = \"box\"\ncells = " + cells + "\nspacing = \"1 mm\"\nmaterial = " + material +
         "\n";
}
inline std::string hold_text(const std::string& face = "x-") {
  return "[[hold]]\nwhere = \"" + face + "\"\n";
}
inline std::string move_text(const std::string& by, const std::string& face = "x+") {
  return "[[move]]\nwhere = \"" + face + "\"\nby = " + by + "\n";
}
/// Held at x-, moved at x+.
inline std::string pulled_box_text(const std::string& cells, const std::string& by) {
  return box_text(cells) + hold_text() + move_text(by);
}

inline std::string world_text(const std::string& cells) {
  return "[world]\ncells = " + cells + "\nspacing = \"1 mm\"\n";
}
/// @param more  further lines
inline std::string object_text(const std::string& name, const std::string& kind, const std::string& cells,
                               const std::string& more = "", const std::string& shape = "box") {
  return "[[object]]\nname = \"" + name + "\"\nkind = \"" + kind + "\"\nshape = \"" + shape +
         "\"\ncells = " + cells + "\n" + more;
}

/// Whether a text has a part: a failure shows the whole text.
inline testing::AssertionResult has(std::string_view text, std::string_view part) {
  const bool is_there = text.find(part) != std::string_view::npos;
  return (is_there ? testing::AssertionSuccess() : testing::AssertionFailure())
         << '"' << part << "\" in: " << text;
}

} // namespace maille::test
