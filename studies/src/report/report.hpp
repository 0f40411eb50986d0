#pragma once
/// One page about a folder of results.

#include <filesystem>
#include <string>
#include <vector>

namespace maille::studies {

struct Report {
  std::string html;
  bool has_results = false;       ///< false: the folder holds nothing that this page is about
  std::vector<std::string> notes; ///< what is missing on the page, and why
};

/// Makes one self-contained page (HTML) of the files that `compare`, `run`, `study`, `trade` and `play` wrote
/// into a folder, and of what `probe --json` did: the question, the body and a slice of its strain, strain,
/// stress and force by part, tables that sort, plots, where the error sits, commands, links to the files. It
/// loads nothing: pictures and plots are data URIs.
///
/// Plots are gnuplot's, pictures render_comparison's, drawn anew from the files for ParaView; where either
/// cannot be had the page is made without, and says so. Texts of files are escaped.
///
/// @param folder  whose files are read; other formats than those are listed by name
/// @param command the line that this page was asked for with
/// @param links   the folder as seen from where the page will stand; empty: it will stand in it
/// Cost  some seconds a picture: one a scene and one a method
/// @throws std::runtime_error where a file of results cannot be read
Report make_report(const std::filesystem::path& folder, const std::string& command,
                   const std::filesystem::path& links = {});

} // namespace maille::studies
