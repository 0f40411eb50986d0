#pragma once
/// Words of tables back to what they stand for.

#include "maille/studies/study_table.hpp"

#include <array>
#include <stdexcept>

namespace maille::studies {

inline constexpr std::array statuses{Status::done,        Status::clamped, Status::budget_reached,
                                     Status::interrupted, Status::refused, Status::failed};
inline constexpr std::array timings{Timing::alone, Timing::busy, Timing::side_by_side};

/// The one of `choices` that to_string calls so. @throws std::invalid_argument
template<class Choices>
auto named(const Choices& choices, const std::string& word) {
  for (const auto choice : choices)
    if (to_string(choice) == word)
      return choice;
  throw std::invalid_argument("\"" + word + "\" is no word of a table");
}

} // namespace maille::studies
