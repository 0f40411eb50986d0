#pragma once
/// Interface between programs and the plugin of finite elements, maille-fem.so.

#include "maille/fem_ref/ranks.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/plugins/open_plugin.hpp"

#include <cstddef>
#include <vector>

namespace maille::fem_ref {

/// The functions of the public headers, and Solver as functions.
struct Functions {
  void (*start_ranks)();
  bool (*agree)(bool on_first);
  Ranks (*ranks)();
  std::vector<std::vector<std::byte>> (*exchange)(std::vector<std::vector<std::byte>> to);
  Communicator* (*communicator)();
  void (*abort_ranks)(int exit_code);
  int (*works_left_behind)();
  Estimate (*estimate)(const Scene& scene, const Options& options);
  Solver* (*new_solver)(const Options& options);
  void (*delete_solver)(Solver* solver);
  Result (*solve)(Solver& solver, const Scene& scene, const Control& control);
};

inline constexpr std::size_t functions_layout =
    layout_of<Functions, Scene, Answer, Control, Options, Result, Estimate, Solver>();

} // namespace maille::fem_ref
