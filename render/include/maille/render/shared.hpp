#pragma once
/// A picture that several processes render together: each casts some objects and merges some tiles. The
/// caller transfers the bytes between them (MPI, files, pipes).

#include "maille/render/renderer.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace maille::render {

/// One of the processes. Each has the whole scene and calls the same functions in the same order:
///
///     received = exchange(renderer.cast(objects, view));    // each process receives its part
///     received = exchange({renderer.compose(received)});    // all to the first
///     picture  = renderer.assemble(received);               // on the first
///
/// Direct send: object o is cast by process o % size, tile t merged by process t % size. Same bits as
/// `Renderer` with any number of processes.
/// Checked by  tests/render/casting_test.cpp
class SharedRenderer {
public:
  using Bytes = std::vector<std::byte>;

  /// @param rank, size  rank of this process and number of processes
  SharedRenderer(int rank, int size, int threads = 1);
  ~SharedRenderer();
  SharedRenderer(const SharedRenderer&) = delete;
  SharedRenderer& operator=(const SharedRenderer&) = delete;

  /// @return runs of this process's objects, one entry per process with the runs in its tiles
  /// @throws std::invalid_argument as Renderer::render does
  std::vector<Bytes> cast(std::span<const SceneObject> objects, const View& view);
  /// @param received  from each process, by its rank. @return the pixels of this process's tiles
  Bytes compose(std::span<const Bytes> received);
  /// @param received  pixels from each process
  Picture assemble(std::span<const Bytes> received) const;
  /// Counters of this process.
  const Counters& counters() const;

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace maille::render
