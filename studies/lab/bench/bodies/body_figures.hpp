#pragma once
/// What the checks of `studies/lab/run bodies` are made of.

#include "bench/bodies/body_case.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille::lab {

/// All to 1e-3.
struct AnsweredBody {
  std::int64_t unknowns = 0;
  bool is_box = false; ///< of one matter, which has a solver of its own
  int materials = 1;
  bool turns = false; ///< every cell has its own fibre, and so a stiffness of its own
  Measured coupled;
  double own_bytes = 0; ///< an unknown
  Seconds two_threads;
  std::optional<BodyCase::Limited> limited;
  std::optional<Measured> fem; ///< the quickest
};

struct BodyFigures {
  std::vector<std::pair<std::string, AnsweredBody>> bodies;
  std::int64_t iterations_gyroid_1e6 = 0;
  double default_over_wide = 0, ns_per_unknown_of_box = 0, iterations_contrast = 0, one_cell_strip_error = 0;
  double peak_gib_huge = 0, two_threads_of_arithmetic = 0;
  std::optional<double> next_frame_over_first_legs, finger_on_calf_fps, ranks_2_difference;
  double finger_on_calf_error = 0;
};

void add_body_checks(const BodyFigures& figures, BenchReport& report);

} // namespace maille::lab
