#pragma once
/// Start of MPI, on demand.

namespace maille::fem_ref {

/// Starts MPI, if the program has not. Trilinos calls MPI even in a single process; the start takes some
/// tenths of a second, so it is delayed until a system needs it.
void start_mpi_once();

} // namespace maille::fem_ref
