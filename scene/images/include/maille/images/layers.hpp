#pragma once
/// An image of one value a voxel, layer by layer from first to last, of which only those that are needed
/// stand in memory.

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

/// Some layers of an image, one behind the other, that moves on from its first layer to its last.
class LayerWindow {
public:
  /// Appends the values of a layer; called for each layer once, in their order. @throws InputError
  using Next = std::function<void(int layer, std::vector<float>& values)>;
  LayerWindow(const ImageInfo& info, Next next) : info_(info), next_(std::move(next)) {}
  /// Window on an image in memory, which must outlive this: always all layers.
  explicit LayerWindow(const Image& image)
      : info_(image.info), end_(image.info.size[2]), data_(image.values.data()) {}
  LayerWindow(const LayerWindow&) = delete;
  LayerWindow& operator=(const LayerWindow&) = delete;
  LayerWindow(LayerWindow&&) = default;
  LayerWindow& operator=(LayerWindow&&) = default;
  ~LayerWindow() = default;

  const ImageInfo& info() const { return info_; }
  /// Values of a layer.
  std::size_t layer_size() const {
    return static_cast<std::size_t>(info_.size[0]) * static_cast<std::size_t>(info_.size[1]);
  }
  /// Layers from `low` on and before `high`, as far as the image has them, are there; those below are gone
  /// for good. Cost  each layer is read once, at most twice as many are kept as are asked for
  void move_to(int low, int high);
  /// @pre the layer of the voxel is there
  float operator[](std::size_t voxel) const { return data_[voxel - first_voxel_]; }
  float at(const Index3& voxel) const {
    const Index3& n = info_.size;
    return (*this)[voxel[0] + std::int64_t{n[0]} * (voxel[1] + std::int64_t{n[1]} * voxel[2])];
  }
  /// @pre it is there
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

/// An image that can be gone through as often as one likes: in memory, or in a file, which is read anew.
class LayeredImage {
public:
  /// @param image must outlive this
  explicit LayeredImage(const Image& image) : info_(image.info), whole_(&image) {}
  /// Reads the header. @throws InputError
  explicit LayeredImage(const std::filesystem::path& file);

  const ImageInfo& info() const { return info_; }
  const std::filesystem::path& path() const { return path_; } ///< empty of one in memory
  /// From now on values within rounding of one of these labels are that label; a reading to the end warns of
  /// them, and of others that are no whole number.
  void round_to(std::vector<float> labels) { labels_ = std::move(labels); }
  /// Takes it as lying at `there`, with axes along the columns of `direction`: another order of axes reads
  /// it as a whole.
  void place(const ImageInfo& there, const std::array<Vec3, 3>& direction);
  /// @param layers that will be asked for at a time
  /// @pre one value a voxel
  /// @throws InputError where the window's layers do not fit into memory, by the header; the window, as
  /// read_image
  LayerWindow open(int layers) const;
  /// The same with `voids` voxels of NaN on both sides along each axis.
  LayeredImage padded(const Index3& voids) const;

private:
  ImageInfo info_;
  Index3 voids_{};
  const Image* whole_ = nullptr;
  std::filesystem::path path_;
  std::shared_ptr<const image_formats::OpenImage> file_;
  std::shared_ptr<const Image> turned_; ///< what `whole_` points to, if that is ours
  std::vector<float> labels_;
};

} // namespace maille
