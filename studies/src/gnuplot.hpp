#pragma once
/// Plots by gnuplot, which need not be there, and how methods look in them.

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace maille::studies {

/// One of gnuplot's strings, in single quotes; line ends are left out.
std::string gnuplot_quoted(const std::string& text);

/// @return why nothing can be drawn, where there is no gnuplot
std::optional<std::string> why_no_gnuplot();

/// Runs gnuplot on commands, without the user's own settings.
/// @throws std::runtime_error with what gnuplot says, where it fails
void run_gnuplot(const std::string& commands);

/// Colour and shape (gnuplot's point type) of a method: apart also where red and green look alike (Wong 2011,
/// Nature Methods 8, 441), by shape too, and told from light grounds and dark ones.
struct MethodLook {
  std::string_view method;
  std::string_view colour;
  int point;
};

inline constexpr std::array<MethodLook, 8> method_looks{{{"limits", "#0072B2", 5},
                                                         {"literal", "#56B4E9", 4},
                                                         {"sweep", "#CC79A7", 8},
                                                         {"relaxed", "#009E73", 9},
                                                         {"coupled", "#D55E00", 7},
                                                         {"fem_q1", "#7F7F7F", 11},
                                                         {"fem_q2", "#1b1f24", 13},
                                                         {"dijkstra", "#B8A000", 3}}};

/// That of a method without one of its own is brown.
constexpr MethodLook look_of(std::string_view method) {
  for (const MethodLook& look : method_looks)
    if (method == look.method)
      return look;
  return {"", "#8C564B", 1};
}

} // namespace maille::studies
