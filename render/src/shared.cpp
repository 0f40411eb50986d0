#include "maille/render/shared.hpp"

#include "compose/compose.hpp"
#include "prepare/prepared_object.hpp"
#include "prepare/request.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <stdexcept>
#include <utility>

namespace maille::render {

namespace {

using Bytes = SharedRenderer::Bytes;

template<class T>
void put(Bytes& to, const T* from, std::size_t n) {
  const auto* bytes = reinterpret_cast<const std::byte*>(from);
  to.insert(to.end(), bytes, bytes + n * sizeof(T));
}

/// Reads the values of `put`, in order.
class Parcel {
public:
  explicit Parcel(std::span<const std::byte> bytes) : bytes_(bytes) {}
  bool empty() const { return bytes_.empty(); }
  template<class T>
  void take(T* to, std::size_t n) {
    if (bytes_.size() < n * sizeof(T))
      throw std::invalid_argument("what another process has sent breaks off");
    std::memcpy(to, bytes_.data(), n * sizeof(T));
    bytes_ = bytes_.subspan(n * sizeof(T));
  }

private:
  std::span<const std::byte> bytes_;
};

struct Head {
  std::int32_t object, tile;
  std::uint32_t n_runs;
};

/// Calls take(first pixel, number) for every row of a tile.
template<class Take>
void for_each_row(int tile, const Picture& picture, Take&& take) {
  const int tiles_x = tiles_along(picture.width);
  const int x0 = tile % tiles_x * tile_edge, y0 = tile / tiles_x * tile_edge;
  const int x1 = std::min(x0 + tile_edge, picture.width), y1 = std::min(y0 + tile_edge, picture.height);
  for (int y = y0; y < y1; ++y)
    take(picture.pixel(x0, y), static_cast<std::size_t>(x1 - x0));
}

} // namespace

struct SharedRenderer::Parts {
  int rank, size, threads;
  View view;
  std::vector<SceneObject> objects;
  std::vector<std::unique_ptr<PreparedObject>> prepared; ///< own objects, and objects in own tiles
  Counters counters;

  const PreparedObject& prepared_of(std::size_t object) {
    if (!prepared[object])
      prepared[object] = std::make_unique<PreparedObject>(objects[object], view, threads, nullptr);
    return *prepared[object];
  }
};

SharedRenderer::SharedRenderer(int rank, int size, int threads) : parts_(std::make_unique<Parts>()) {
  if (size < 1 || rank < 0 || rank >= size)
    throw std::invalid_argument("a process has a rank from 0 to one less than there are processes");
  parts_->rank = rank;
  parts_->size = size;
  parts_->threads = std::max(1, threads);
}
SharedRenderer::~SharedRenderer() = default;

std::vector<Bytes> SharedRenderer::cast(std::span<const SceneObject> objects, const View& view) {
  check_request(objects, view);
  Parts& parts = *parts_;
  parts.view = view;
  parts.objects.assign(objects.begin(), objects.end());
  parts.prepared.clear();
  parts.prepared.resize(objects.size());
  const std::size_t size = parts.size;
  std::vector<Bytes> to(size);
  for (std::size_t o = parts.rank; o < objects.size(); o += size) {
    std::vector<TileRuns> tiles;
    parts.counters.rays += cast_tiles(parts.prepared_of(o), view, parts.threads, tiles);
    ++parts.counters.objects;
    for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
      const TileRuns& of = tiles[tile];
      if (of.empty())
        continue;
      const Head head{static_cast<std::int32_t>(o), static_cast<std::int32_t>(tile),
                      static_cast<std::uint32_t>(of.runs.size())};
      put(to[tile % size], &head, 1);
      put(to[tile % size], of.first.data(), tile_pixels + 1);
      put(to[tile % size], of.runs.data(), of.runs.size());
    }
  }
  return to;
}

Bytes SharedRenderer::compose(std::span<const Bytes> received) {
  Parts& parts = *parts_;
  std::map<std::int32_t, std::map<std::int32_t, TileRuns>> tiles; // tile -> object -> runs
  for (const Bytes& bytes : received)
    for (Parcel parcel(bytes); !parcel.empty();) {
      Head head{};
      parcel.take(&head, 1);
      if (head.object < 0 || static_cast<std::size_t>(head.object) >= parts.objects.size())
        throw std::invalid_argument("another process has sent an object that this one does not have");
      TileRuns& of = tiles[head.tile][head.object];
      of.first.resize(tile_pixels + 1);
      of.runs.resize(head.n_runs);
      parcel.take(of.first.data(), of.first.size());
      parcel.take(of.runs.data(), of.runs.size());
    }
  std::vector<TileLayers> work;
  for (const auto& [tile, layers] : tiles) {
    work.emplace_back(tile, std::vector<TileLayer>());
    for (const auto& [object, runs] : layers)
      work.back().second.push_back({object, &runs, &parts.prepared_of(static_cast<std::size_t>(object))});
  }
  Picture picture;
  clear(picture, parts.view.width, parts.view.height);
  compose_tiles(
      static_cast<int>(work.size()), [&](int item) { return work[item]; }, parts.threads, picture,
      parts.counters);
  Bytes bytes;
  for (const auto& [tile, layers] : work) {
    const std::int32_t number = tile;
    put(bytes, &number, 1);
    for_each_row(tile, picture, [&](std::size_t first, std::size_t n) {
      put(bytes, picture.rgba.data() + first, n);
      put(bytes, picture.depth.data() + first, n);
      put(bytes, picture.object.data() + first, n);
    });
  }
  return bytes;
}

Picture SharedRenderer::assemble(std::span<const Bytes> received) const {
  Picture picture;
  clear(picture, parts_->view.width, parts_->view.height);
  for (const Bytes& bytes : received)
    for (Parcel parcel(bytes); !parcel.empty();) {
      std::int32_t tile = 0;
      parcel.take(&tile, 1);
      for_each_row(tile, picture, [&](std::size_t first, std::size_t n) {
        parcel.take(picture.rgba.data() + first, n);
        parcel.take(picture.depth.data() + first, n);
        parcel.take(picture.object.data() + first, n);
      });
    }
  return picture;
}

const Counters& SharedRenderer::counters() const {
  return parts_->counters;
}

} // namespace maille::render
