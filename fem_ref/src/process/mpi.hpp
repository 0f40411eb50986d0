#pragma once
/// The start of MPI, where a library needs it.

namespace maille::fem_ref {

/// Trilinos calls MPI even in one process. Starting it takes some tenths of a second, so it waits until a
/// system needs it, and it is left alone where the program has started MPI itself.
void start_mpi_once();

} // namespace maille::fem_ref
