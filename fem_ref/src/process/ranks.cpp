#include "maille/fem_ref/ranks.hpp"

#include "process/mpi.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <limits>
#include <mpi.h>
#include <p4est.h>
#include <span>
#include <stdexcept>
#include <unistd.h>

namespace maille::fem_ref {
namespace {

Ranks known;

/// Selects a writable folder for MPI, which ends the process without one. @throws std::runtime_error
void find_a_folder_for_mpi() {
  const auto serves = [](const std::string& folder) { // permissions are not sufficient, for instance in /proc
    std::string own = folder + "/maille_XXXXXX";
    return mkdtemp(own.data()) != nullptr && rmdir(own.c_str()) == 0;
  };
  const char* asked = "/tmp"; // in Open MPI's order
  for (const char* variable : {"TMP", "TEMP", "TMPDIR"})
    if (const char* const value = std::getenv(variable))
      asked = value;
  if (serves(asked))
    return;
  for (const char* const other : {"/tmp", "/var/tmp", "/dev/shm"})
    if (serves(other)) {
      setenv("OMPI_MCA_orte_tmpdir_base", other, 0);
      return;
    }
  throw std::runtime_error(
      fmt::format("MPI, which AMG needs, has no folder for its files: {} cannot be written", asked));
}

} // namespace

void start_mpi_once() {
  static const bool started = [] {
    int is_running = 0;
    MPI_Initialized(&is_running);
    if (is_running != 0)
      return false;
    if (announced_ranks() < 2)
      find_a_folder_for_mpi();
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    std::atexit([] {
      int is_over = 0;
      MPI_Finalized(&is_over);
      if (is_over == 0)
        MPI_Finalize();
    });
    return true;
  }();
  static_cast<void>(started);
}

void start_ranks() {
  if (announced_ranks() < 2)
    return;
  start_mpi_once();
  sc_init(MPI_COMM_WORLD, 0, 0, nullptr, SC_LP_SILENT); // otherwise p4est prints its steps to stdout
  p4est_init(nullptr, SC_LP_SILENT);
  MPI_Comm_rank(MPI_COMM_WORLD, &known.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &known.size);
  MPI_Comm here{};
  int place = 0;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
  MPI_Comm_rank(here, &place);
  MPI_Comm_free(&here);
  const int first_of_its_machine = place == 0 ? 1 : 0;
  MPI_Allreduce(&first_of_its_machine, &known.machines, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
}

Ranks ranks() {
  return known;
}

bool agree(bool on_first) {
  if (known.size < 2)
    return on_first;
  int value = on_first ? 1 : 0;
  MPI_Bcast(&value, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return value != 0;
}

std::vector<std::vector<std::byte>> exchange(std::vector<std::vector<std::byte>> to) {
  if (known.size < 2)
    return to;
  const auto n = static_cast<std::size_t>(known.size);
  std::vector<long long> sent(n), announced_sizes(n);
  for (std::size_t r = 0; r < n; ++r)
    sent[r] = static_cast<long long>(to.at(r).size());
  MPI_Alltoall(sent.data(), 1, MPI_LONG_LONG, announced_sizes.data(), 1, MPI_LONG_LONG, MPI_COMM_WORLD);
  const bool is_too_long =
      std::max(*std::ranges::max_element(sent), *std::ranges::max_element(announced_sizes)) >
      std::numeric_limits<int>::max();
  if (is_too_long)
    throw std::length_error("more than 2 GiB for one process from another");
  std::vector<std::vector<std::byte>> from(n);
  std::vector<MPI_Request> requests(2 * n);
  constexpr int tag = 22;
  for (std::size_t r = 0; r < n; ++r) {
    from[r].resize(announced_sizes[r]);
    MPI_Irecv(from[r].data(), static_cast<int>(announced_sizes[r]), MPI_BYTE, static_cast<int>(r), tag,
              MPI_COMM_WORLD, &requests[r]);
    MPI_Isend(to[r].data(), static_cast<int>(sent[r]), MPI_BYTE, static_cast<int>(r), tag, MPI_COMM_WORLD,
              &requests[n + r]);
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  return from;
}

namespace {

class MpiCommunicator : public Communicator {
public:
  int rank() const override { return known.rank; }
  int size() const override { return known.size; }
  void exchange(std::span<const Part> to, std::span<const Part> from) override {
    requests_.clear();
    for (const Part& part : from)
      for_pieces(part, [&](std::byte* bytes, int n) {
        MPI_Irecv(bytes, n, MPI_BYTE, part.rank, tag, MPI_COMM_WORLD, &requests_.emplace_back());
      });
    for (const Part& part : to)
      for_pieces(part, [&](const std::byte* bytes, int n) {
        MPI_Isend(bytes, n, MPI_BYTE, part.rank, tag, MPI_COMM_WORLD, &requests_.emplace_back());
      });
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  }

private:
  static constexpr int tag = 23;
  /// Messages have int's length at most; messages between two ranks arrive in order.
  template<class Send>
  static void for_pieces(const Part& part, const Send& send) {
    constexpr std::size_t longest = std::size_t{1} << 30;
    for (std::size_t at = 0; at < part.bytes.size(); at += longest)
      send(part.bytes.data() + at, static_cast<int>(std::min(longest, part.bytes.size() - at)));
  }

  std::vector<MPI_Request> requests_;
};

} // namespace

Communicator* communicator() {
  static MpiCommunicator all;
  return known.size < 2 ? nullptr : &all;
}

void abort_ranks(int exit_code) {
  if (known.size > 1)
    MPI_Abort(MPI_COMM_WORLD, exit_code);
}

} // namespace maille::fem_ref
