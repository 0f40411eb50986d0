#pragma once
/// Whether the answer that a comparison trusts deserves it.

#include "maille/studies/comparison.hpp"

#include <string>
#include <vector>

namespace maille::studies {

/// Sentences for people where the reference of a comparison may be far off itself: how far, and how we know.
///
/// An error of a lattice method against finite elements that is more than 1.5 times the method's estimated
/// error (add_estimates) and 2 % is the reference's for the most part: it is off by what the error leaves, at
/// most by error and estimate together. One of less than a third of the estimate, where that is 5 %, means
/// that both share an error. Without estimates, that of a settled `coupled` which is more than 3 % from its
/// reference is made here. Where that says nothing, or there is no `coupled`, linear elements are warned of
/// by what they are known to lock on: Poisson ratios of 0.45 and more, and bodies of fewer than four cells
/// across. Nothing is said of the reference "best", which knows its own error, and of a reference that has no
/// answer.
///
/// Cost     nothing, or one estimate (about that of `coupled`, see deform::estimate_error)
std::vector<std::string> reference_warnings(const Scene& scene, const Comparison& comparison,
                                            const Control& control);

} // namespace maille::studies
