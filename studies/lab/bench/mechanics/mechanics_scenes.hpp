#pragma once
/// The bodies that `studies/lab/run mechanics` asks about.

#include "bench/bench_report.hpp"

#include <optional>
#include <string>
#include <vector>

namespace maille::lab {

/// Which lattices quadratic elements are solved on to be held against: the scene's own (forces alone, where a
/// finer one cannot be afforded), one of half the spacing (a stand-in for a body whose own is too large), or
/// both.
enum class ReferenceLattices { same, finer, both };

struct MechanicsScene {
  std::string name;
  Scene scene;
  ReferenceLattices lattices = ReferenceLattices::both;
};

/// Those that are there: a note of the report says which are left out.
/// @throws InputError where images in MAILLE_DATA are others than the scenes expect
std::vector<MechanicsScene> mechanics_scenes(const BenchOptions& options, BenchReport& report);

/// A block of two tissues, labels 1 below and 2 above, pulled along its fibres by 1/16.
Scene two_tissue_block(int cells_across);

/// Both legs of a calf, where MAILLE_DATA has them; nothing otherwise.
std::optional<Scene> both_legs();

} // namespace maille::lab
