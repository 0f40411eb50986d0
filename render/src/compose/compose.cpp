#include "compose/compose.hpp"

#include "data/parallel.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <span>

namespace maille::render {

void clear(Picture& picture, int width, int height) {
  picture.width = width;
  picture.height = height;
  const auto n = static_cast<std::size_t>(width) * height;
  picture.rgba.assign(n, {});
  picture.depth.assign(n, std::numeric_limits<float>::infinity());
  picture.object.assign(n, -1);
}

namespace {

struct Piece {
  const Run* run;
  std::int32_t layer;
};

/// Order by depth; for equal depth by object number.
bool is_before(const Piece& a, const Piece& b) {
  return a.run->middle() != b.run->middle() ? a.run->middle() < b.run->middle() : a.layer < b.layer;
}

class TileComposer {
public:
  TileComposer(int tile, std::span<const TileLayer> layers, Picture& picture)
      : tile_(tile), layers_(layers), picture_(picture), tiles_x_(tiles_along(picture.width)) {}

  Counters run() {
    const int x0 = tile_ % tiles_x_ * tile_edge, y0 = tile_ / tiles_x_ * tile_edge;
    const int x1 = std::min(x0 + tile_edge, picture_.width), y1 = std::min(y0 + tile_edge, picture_.height);
    if (layers_.size() == 1) // runs of one object are sorted
      blend_one(x0, y0, x1, y1);
    else
      blend_all(x0, y0, x1, y1);
    counts_.pixels_merged = std::int64_t{1} * (x1 - x0) * (y1 - y0);
    cast_again();
    return counts_;
  }

private:
  void gather(std::int32_t pixel) {
    pieces_.clear();
    const std::size_t p = pixel;
    for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
      const TileRuns& of = *layers_[layer].runs;
      for (std::uint32_t r = of.first[p]; r < of.first[p + 1]; ++r)
        pieces_.push_back({&of.runs[r], static_cast<std::int32_t>(layer)});
    }
    std::sort(pieces_.begin(), pieces_.end(), is_before);
  }

  /// True if a run begins before another object's has ended.
  bool overlaps() const {
    for (std::size_t i = 0; i + 1 < pieces_.size(); ++i)
      for (std::size_t j = i + 1; j < pieces_.size(); ++j)
        if (pieces_[j].layer != pieces_[i].layer && pieces_[j].run->begin < pieces_[i].run->end &&
            pieces_[i].run->begin < pieces_[j].run->end)
          return true;
    return false;
  }

  /// Composites runs, nearest first.
  struct Blended {
    std::array<float, 4> sum{};
    float depth = std::numeric_limits<float>::infinity();
    std::int32_t object = -1;

    /// Same as adding one run to an empty result.
    void only(const Run& run, std::int32_t of) {
      sum = run.rgba;
      const bool is_seen = sum[3] >= 0.5f;
      depth = is_seen ? run.half : depth;
      object = is_seen ? of : object;
    }
    void add(const Run& run, std::int32_t of) {
      const float clear = 1 - sum[3];
      for (std::size_t c = 0; c < 4; ++c)
        sum[c] += clear * run.rgba[c];
      if (object < 0 && sum[3] >= 0.5f) {
        depth = run.half;
        object = of;
      }
    }
  };

  void keep(const Blended& blended, std::size_t to) {
    picture_.rgba[to] = blended.sum;
    picture_.depth[to] = blended.depth;
    picture_.object[to] = blended.object;
  }
  void blend(std::size_t to) {
    Blended blended;
    for (const Piece& piece : pieces_)
      blended.add(*piece.run, layers_[piece.layer].object);
    keep(blended, to);
  }
  void blend_all(int x0, int y0, int x1, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        const std::int32_t pixel = x - x0 + tile_edge * (y - y0);
        gather(pixel);
        if (overlaps())
          interleaved_.push_back(pixel);
        else
          blend(picture_.pixel(x, y));
      }
  }
  /// Uses local pointers, because most pixels of most pictures have one object.
  void blend_one(int x0, int y0, int x1, int y1) {
    const std::int32_t object = layers_.front().object;
    const Run* const runs = layers_.front().runs->runs.data();
    for (int y = y0; y < y1; ++y) {
      const std::uint32_t* const first =
          layers_.front().runs->first.data() + static_cast<std::size_t>(tile_edge * (y - y0));
      const std::size_t to = picture_.pixel(x0, y), n = static_cast<std::size_t>(x1 - x0);
      std::array<float, 4>* const rgba = picture_.rgba.data() + to;
      float* const depth = picture_.depth.data() + to;
      std::int32_t* const objects = picture_.object.data() + to;
      for (std::size_t i = 0; i < n; ++i) {
        Blended blended;
        if (first[i + 1] - first[i] == 1)
          blended.only(runs[first[i]], object);
        else
          for (std::uint32_t r = first[i]; r < first[i + 1]; ++r)
            blended.add(runs[r], object);
        rgba[i] = blended.sum;
        depth[i] = blended.depth;
        objects[i] = blended.object;
      }
    }
  }

  void cast_again() {
    if (interleaved_.empty())
      return;
    RunSink sink;
    std::vector<TileRuns> samples(layers_.size());
    std::vector<TileLayer> layers(layers_.begin(), layers_.end());
    for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
      sink.clear();
      counts_.rays_again += layers_[layer].prepared->cast_one_by_one(tile_, interleaved_, sink);
      sink.take(samples[layer]);
      if (samples[layer].first.empty())
        samples[layer].first.assign(tile_pixels + 1, 0);
      layers[layer].runs = &samples[layer];
    }
    layers_ = layers;
    const int x0 = tile_ % tiles_x_ * tile_edge, y0 = tile_ / tiles_x_ * tile_edge;
    for (const std::int32_t pixel : interleaved_) {
      gather(pixel);
      blend(picture_.pixel(x0 + pixel % tile_edge, y0 + pixel / tile_edge));
    }
  }

  int tile_;
  std::span<const TileLayer> layers_;
  Picture& picture_;
  int tiles_x_;
  std::vector<Piece> pieces_;
  std::vector<std::int32_t> interleaved_;
  Counters counts_;
};

} // namespace

void compose_tiles(int n, const std::function<TileLayers(int)>& layers_of, int threads, Picture& picture,
                   Counters& counters) {
  std::atomic<std::int64_t> rays{0}, pixels{0};
  for_each_item(threads, n, [&](int item, int) {
    const auto [tile, layers] = layers_of(item);
    const Counters counts = TileComposer(tile, layers, picture).run();
    rays += counts.rays_again;
    pixels += counts.pixels_merged;
  });
  counters.rays += rays;
  counters.rays_again += rays;
  counters.pixels_merged += pixels;
}

} // namespace maille::render
