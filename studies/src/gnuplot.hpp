#pragma once
/// Plots by gnuplot, which need not be there.

#include <optional>
#include <string>

namespace maille::studies {

/// One of gnuplot's strings, in single quotes; line ends are left out.
std::string gnuplot_quoted(const std::string& text);

/// @return why nothing can be drawn, where there is no gnuplot
std::optional<std::string> why_no_gnuplot();

/// Runs gnuplot on commands, without the user's own settings.
/// @throws std::runtime_error with what gnuplot says, where it fails
void run_gnuplot(const std::string& commands);

} // namespace maille::studies
