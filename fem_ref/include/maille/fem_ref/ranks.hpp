#pragma once
/// Parallel runs of one scene on several processes (`mpirun -n N`), and threads that outlive a stopped solve.

#include "maille/base/communicator.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace maille::fem_ref {

/// Place of this process among the ranks; rank 0 of 1 without mpirun.
struct Ranks {
  int rank = 0;
  int size = 1;
  int machines = 1; ///< number of machines that the ranks run on
  bool is_first() const { return rank == 0; }
};

/// Starts MPI if mpirun (Open MPI, or a launcher that speaks PMI) started this process as one of several;
/// else does nothing. A program that supports several ranks must call it first; without the call it runs on
/// one rank.
void start_ranks();
/// Number of processes that the launcher (mpirun) announces, before MPI starts; 1 without a launcher.
int announced_ranks();
Ranks ranks();
/// Broadcasts the first rank's value to all ranks. Collective: all ranks must call it.
bool agree(bool on_first);
/// Sends a message to each rank. Collective: all ranks must call it. @param to  messages by rank, one per
/// rank @return received messages by rank. @throws std::length_error beyond 2 GiB from one rank to another
std::vector<std::vector<std::byte>> exchange(std::vector<std::vector<std::byte>> to);
/// Communicator for other parallel methods; null on a single rank. Valid until the process ends.
Communicator* communicator();
/// Ends all ranks at once if there are several: for an error on this rank only.
void abort_ranks(int exit_code);

/// Number of threads that still run abandoned work: the caller has asked to stop, but a library call
/// (factorisation, analysis, hierarchy of meshes) cannot be interrupted. They end as soon as the library
/// returns, and use no memory of a caller. A program that ends while any of them run must flush its output
/// and call std::_Exit, because they still use objects that static destructors of libraries would destroy.
int works_left_behind();

} // namespace maille::fem_ref
