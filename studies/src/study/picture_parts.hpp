#pragma once
/// The two kinds of pictures of a study, as commands for gnuplot: curves over every parameter, and maps over
/// two. All plots of a picture have one scale.

#include "study/response.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// A number of a parameter in a row; NaN where that is a text, or none.
double number_of(const StudyRow& row, const std::string& parameter);

/// Parameters of numbers, and of texts, that have several values, in the order of the table.
struct VariedParameters {
  std::vector<std::string> numbers, texts;
};
VariedParameters varied_parameters(const std::vector<StudyRow>& rows);

/// Of values that span a factor of 30 and more, all above 0: they stand in decades.
bool spans_decades(double least, double most);
/// An axis a little longer than its values.
std::string gnuplot_axis(char name, double least, double most);

/// Head of a multiplot of `n_plots` plots, under a title. @return the text before its plots
std::string head_of_picture(std::size_t n_plots, const std::string& title, const std::filesystem::path& file,
                            bool is_map);
inline constexpr int plots_across = 3, plot_width = 400, plot_height = 300, head_height = 70;

/// A map a scene and method over two parameters of numbers. On a whole grid colours and lines of equal value,
/// else a coloured point a case. @return nothing unless those two alone are varied, and not along a line
std::optional<std::string> map_script(const std::vector<StudyRow>& rows, const Response& response,
                                      const std::string& title, const std::filesystem::path& file);

/// A plot a scene and parameter that has several values. Of numbers a curve a method through medians in a
/// band from the least to the most of the cases that share a value; of texts a bar; points where no two
/// cases share one. @return nothing where there are none
std::optional<std::string> curve_script(const std::vector<StudyRow>& rows, const Response& response,
                                        const std::string& title, const std::filesystem::path& file);

} // namespace maille::studies
