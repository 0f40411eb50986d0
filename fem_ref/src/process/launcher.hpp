#pragma once
/// What is known of several processes before MPI has started.

namespace maille::fem_ref {

/// How many processes the launcher (mpirun) says it has started; 1 without one.
int announced_ranks();

} // namespace maille::fem_ref
