#include "export/body_numbering.hpp"
#include "export/calculix/calculix.hpp"
#include "export/whole_file.hpp"
#include "maille/materials/text_file.hpp"
#include "program.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace maille::studies {

namespace {

/// Error lines in ccx's output; empty without errors.
std::string errors_in(const std::string& output) {
  const std::size_t at = output.find("*ERROR");
  if (at == std::string::npos)
    return {};
  std::string line = output.substr(at, output.find("\n\n", at) - at);
  return line.substr(0, 400);
}

} // namespace

Displacement read_calculix_displacement(const Scene& scene, std::istream& printed) {
  const std::vector<std::int64_t> nodes = matter_only(scene.specimen).nodes;
  std::vector<bool> is_known(nodes.size(), false);
  Displacement u(scene.specimen.grid);
  for (std::string line; std::getline(printed, line);) {
    std::istringstream fields(line);
    std::int64_t id = 0;
    Vec3 value{};
    if (!(fields >> id >> value[0] >> value[1] >> value[2]) || id < 1 ||
        id > static_cast<std::int64_t>(nodes.size()))
      continue;
    const std::size_t i = id - 1;
    is_known[i] = true;
    for (int b = 0; b < scene.dimension(); ++b)
      u(b, nodes[i]) = value[b];
  }
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!is_known[i])
      throw std::runtime_error(fmt::format("CalculiX printed no displacement of node {}", i + 1));
  return u;
}

bool has_calculix() {
  return has_program("ccx");
}

Answer solve_by_calculix(const Scene& scene, const Control& control) {
  if (!has_calculix())
    return refusal("calculix", "there is no `ccx` to run: install the package calculix-ccx");
  if (const std::string reason = why_no_deck(scene); !reason.empty())
    return refusal("calculix", reason);
  const Vec3 spacing = scene.specimen.grid.spacing();
  // ccx treats a cell with a Jacobian below 1e-20 m^3 as inverted.
  if (spacing[0] * spacing[1] * spacing[2] / 8 < 2e-20)
    return refusal(
        "calculix",
        "cells of less than about half a micrometre are too small for CalculiX, which counts in metres");
  const WorkFolder folder("maille_ccx");
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  write_whole(folder / "scene.inp", calculix_deck(scene));
  Answer answer;
  answer.method = "calculix";
  answer.algorithm = scene.strain == Strain::finite ? "CalculiX, C3D8 bricks, NLGEOM, its own laws"
                                                    : "CalculiX, C3D8 bricks, SPOOLES";
  answer.seconds.setup = seconds();
  if (control.progress)
    control.progress(0, "CalculiX");
  // Sums of several threads differ in the last digits; one thread gives the same bits every time.
  const auto status =
      run_program(fmt::format("cd {} && OMP_NUM_THREADS=1 exec ccx -i scene > output.txt 2>&1",
                              shell_word((folder / ".").string())),
                  [&] { return control.should_stop(); });
  answer.seconds.solve = seconds() - answer.seconds.setup;
  if (!status) {
    answer.status = Status::interrupted;
    answer.message = "ccx was ended";
    answer.displacement = Displacement(scene.specimen.grid);
    return answer;
  }
  const std::string errors = errors_in(
      read_own_text_file(folder / "output.txt", "what ccx says", std::numeric_limits<std::int64_t>::max()));
  if (*status != 0 || !errors.empty()) {
    answer.status = Status::failed;
    answer.message =
        errors.empty() ? fmt::format("ccx ended with status {}", *status) : "ccx says: " + errors;
    return answer;
  }
  try {
    std::ifstream printed(folder / "scene.dat");
    answer.displacement = read_calculix_displacement(scene, printed);
  } catch (const std::runtime_error& error) {
    answer.status = Status::failed;
    answer.message = error.what();
  }
  return answer;
}

} // namespace maille::studies
