#pragma once
/// What a row of a study holds, in every form.

#include "maille/studies/study_table.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

template<>
struct Choices<Timing> {
  static constexpr std::array all{Timing::alone, Timing::busy, Timing::side_by_side};
};

const ResultTable<StudyRow>& columns_of_study();

} // namespace maille::studies
