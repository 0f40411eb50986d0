#pragma once
/// Access to an image with one value per voxel, layer by layer from first to last, with only the needed
/// layers in memory.

#include "maille/images/image.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace maille {

namespace image_formats {
struct OpenImage;
}

/// A window of consecutive layers of an image that moves from the first layer to the last.
class LayerWindow {
public:
  /// Appends the values of a layer; called once per layer, in order. @throws InputError
  using Next = std::function<void(int layer, std::vector<float>& values)>;
  LayerWindow(const ImageInfo& info, Next next) : info_(info), next_(std::move(next)) {}
  /// Window on an image in memory, which must outlive this: contains all layers always.
  explicit LayerWindow(const Image& image)
      : info_(image.info), end_(image.info.size[2]), data_(image.values.data()) {}
  LayerWindow(const LayerWindow&) = delete;
  LayerWindow& operator=(const LayerWindow&) = delete;
  LayerWindow(LayerWindow&&) = default;
  LayerWindow& operator=(LayerWindow&&) = default;
  ~LayerWindow() = default;

  const ImageInfo& info() const { return info_; }
  /// Number of values of a layer.
  std::size_t layer_size() const {
    return static_cast<std::size_t>(info_.size[0]) * static_cast<std::size_t>(info_.size[1]);
  }
  /// Loads the layers from `low` to before `high`, as far as the image has them; those below are discarded
  /// for good. Cost  each layer is read once; at most twice the requested layers are stored
  void move_to(int low, int high);
  /// @pre the layer of the voxel is loaded
  float operator[](std::size_t voxel) const { return data_[voxel - first_voxel_]; }
  float at(const Index3& voxel) const {
    const Index3& n = info_.size;
    return (*this)[voxel[0] + std::int64_t{n[0]} * (voxel[1] + std::int64_t{n[1]} * voxel[2])];
  }
  /// @pre it is loaded
  std::span<const float> layer(int k) const {
    return {data_ + (static_cast<std::size_t>(k) * layer_size() - first_voxel_), layer_size()};
  }

private:
  ImageInfo info_;
  Next next_;
  std::vector<float> values_;
  int first_ = 0, end_ = 0;     ///< layers in `values_`
  std::size_t first_voxel_ = 0; ///< the first one in `data_`
  const float* data_ = nullptr;
};

/// An image that can be read repeatedly: in memory, or in a file, which each window reads anew.
class LayeredImage {
public:
  /// @param image must outlive this
  explicit LayeredImage(const Image& image) : info_(image.info), whole_(&image) {}
  /// Reads the header. @throws InputError
  explicit LayeredImage(const std::filesystem::path& file);

  const ImageInfo& info() const { return info_; }
  const std::filesystem::path& path() const { return path_; } ///< empty for an image in memory
  /// Rounds values to these labels when windows read them; after a complete read, warns of rounded values and
  /// of other values that are not whole numbers.
  void round_to(std::vector<float> labels) { labels_ = std::move(labels); }
  /// Sets the position to `there`, with axes along the columns of `direction`: a different order of axes
  /// reads the whole image.
  void place(const ImageInfo& there, const std::array<Vec3, 3>& direction);
  /// @param layers largest number of layers per move
  /// @pre one value a voxel
  /// @throws InputError if the window's layers exceed the memory, by the header; windows throw as read_image
  LayerWindow open(int layers) const;
  /// The same image with `voids` voxels of NaN added on both sides of each axis.
  LayeredImage padded(const Index3& voids) const;

private:
  ImageInfo info_;
  Index3 voids_{};
  const Image* whole_ = nullptr;
  std::filesystem::path path_;
  std::shared_ptr<const image_formats::OpenImage> file_;
  std::shared_ptr<const Image> turned_; ///< owner of *whole_, if this made it
  std::vector<float> labels_;
};

} // namespace maille
