#pragma once
/// Columns shared by several tables, under the same names.

#include "maille/base/arena.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "results/result_table.hpp"
#include "text.hpp"

namespace maille::studies {

/// Bytes as text; the memory of other programs is unknown.
inline std::string memory_in_words(double bytes) {
  return bytes > 0 ? bytes_in_words(bytes) : "-";
}

/// @param path to the method's name
template<class Row, class... Path>
void add_method(ResultTable<Row>& columns, Path... path) {
  columns.add({"method", "method", "", "that answered"}, {"method", -9}, path...);
}

/// @param path to the Status
template<class Row, class... Path>
void add_status(ResultTable<Row>& columns, Path... path) {
  columns.add({"status", "status", "", "how it ended"}, {"status", -14}, path...);
}

/// setup_s and solve_s. @param path to Seconds
template<class Row, class... Path>
void add_seconds(ResultTable<Row>& columns, Path... path) {
  columns.add({"setup_s", "seconds.setup", "s", "before the first iteration"}, {"set-up", 9, in_seconds},
              path..., &Seconds::setup);
  columns.add({"solve_s", "seconds.solve", "s", "after it"}, {"solve", 9, in_seconds}, path...,
              &Seconds::solve);
}

template<class Row, class... Path>
ResultTable<Row>& add_total(ResultTable<Row>& columns, Path... path) {
  return columns.add({"total_s", "seconds.total", "s", "set-up and solve"}, {"total", 9, in_seconds},
                     path...);
}

template<class Row, class... Path>
ResultTable<Row>& add_bytes(ResultTable<Row>& columns, Path... path) {
  return columns.add({"bytes", "bytes", "B", "held by the method at its peak"},
                     {"memory", 10, memory_in_words}, path...);
}

template<class Row, class... Path>
ResultTable<Row>& add_iterations(ResultTable<Row>& columns, Path... path) {
  return columns.add({"iterations", "iterations", "", "sweeps, iterations, or nodes settled"}, {"iter.", 9},
                     path...);
}

template<class Row, class... Path>
ResultTable<Row>& add_limit_violation(ResultTable<Row>& columns, Path... path) {
  return columns.add(
      {"limit_violation", "limit_violation", "spacings", "largest excess of a link over its limits"},
      {"violation", 10, [](double excess) { return fmt::format("{:.2g}", excess); }}, path...);
}

/// relative_l2, relative_max and rms_m, in JSON one group. @param path to ErrorNorms, perhaps optional
template<class Row, class... Path>
void add_norms(ResultTable<Row>& columns, const std::string& prefix, const std::string& group, Path... path) {
  columns.add({prefix + "relative_l2", group + ".relative_l2", "", "|u - r| / |r|"},
              {"L2 error", 10, in_percent}, path..., &ErrorNorms::relative_l2);
  columns.add({prefix + "relative_max", group + ".relative_max", "", "largest |u - r| over largest |r|"},
              {"max error", 10, in_percent}, path..., &ErrorNorms::relative_max);
  columns.add({prefix + "rms_m", group + ".rms", "m", "root mean square of |u - r|"}, path...,
              &ErrorNorms::rms);
}

/// What a scene's [test] comes to. @param path to an optional TestResult
template<class Row, class... Path>
void add_test(ResultTable<Row>& columns, Path... path) {
  columns.add(
      {"test_reaction", "test.reaction", "N", "of the scene's [test]; of a bent body the moment, N m"},
      path..., &TestResult::reaction);
  columns.add({"test_stiffness", "test.stiffness", "N/m", "reaction over displacement, or N m/rad"}, path...,
              &TestResult::stiffness);
  columns.add({"test_apparent_modulus", "test.apparent_modulus", "Pa", "of a homogeneous body like it"},
              path..., &TestResult::apparent_modulus);
  columns.add({"test_failure", "test.failure", "N", "reaction at which the tissue fails"}, path...,
              &TestResult::failure);
}

} // namespace maille::studies
