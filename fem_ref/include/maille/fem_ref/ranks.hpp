#pragma once
/// Several processes that answer one scene together, as `mpirun -n N` starts them, and threads left behind.

#include "maille/base/communicator.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maille::fem_ref {

/// Place of this process among those that were started together; one of one without mpirun.
struct Ranks {
  int rank = 0;
  int size = 1;
  int machines = 1; ///< that they run on
  bool is_first() const { return rank == 0; }
};

/// Starts MPI where the process was started by mpirun (Open MPI, or a launcher that speaks PMI) as one of
/// several; does nothing else. Called first thing by a program that wants to be run so; a program that does
/// not call it never is.
void start_ranks();
/// How many processes the launcher (mpirun) says it has started, before MPI has; 1 without one.
int announced_ranks();
Ranks ranks();
/// What the first rank says, on every rank. All must call it.
bool agree(bool on_first);
/// To every rank what is meant for it. All must call it. @param to  by rank, as many as there are
/// @return from every rank, by rank. @throws std::length_error beyond 2 GiB from one rank to another
std::vector<std::vector<std::byte>> exchange(std::vector<std::vector<std::byte>> to);
/// What other methods share their work by; null where there is one rank. It stays.
Communicator* communicator();
/// Ends all ranks at once where there are several: for an error that only this one has met.
void abort_ranks(int exit_code);

/// Threads that are still at work that was left behind because its caller asked to stop and a library would
/// not: a factorisation, an analysis, a hierarchy of meshes. They end by themselves as soon as the library
/// gives way, and touch nothing that a caller owns. A program that ends while there are any has to leave by
/// std::_Exit, after its output is flushed: the objects that its libraries would destroy are in use.
int works_left_behind();

} // namespace maille::fem_ref
