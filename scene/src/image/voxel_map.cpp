#include "maille/scene/voxel_map.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>

namespace maille {

namespace {

bool has_same_axes(const ImageInfo& info, const Placement& placement) {
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t a = 0; a < 3; ++a)
      if (std::abs(info.direction[row][a] - placement.direction[row][a]) > 1e-4)
        return false;
  return true;
}

} // namespace

std::optional<VoxelBlocks> voxel_blocks(const ImageInfo& info, const Specimen& body) {
  if (!has_same_axes(info, body.placement))
    return std::nullopt;
  const Vec3 centre = point_in_object(body.placement, info.origin);
  VoxelBlocks blocks;
  for (std::size_t a = 0; a < 3; ++a) {
    const double ratio = body.grid.spacing()[a] / info.spacing[a];
    const double offset = (body.origin[a] - (centre[a] - info.spacing[a] / 2)) / info.spacing[a];
    const double whole = std::round(ratio), first = std::round(offset);
    // Over the whole body: headers hold float32.
    constexpr double tolerance = 0.01, most = 1e9;
    const bool is_whole = whole >= 1 && whole < most &&
                          std::abs(ratio - whole) * body.grid.cells()[a] <= tolerance &&
                          std::abs(offset - first) <= tolerance && std::abs(first) < most;
    if (!is_whole)
      return std::nullopt;
    blocks.per_cell[a] = static_cast<int>(whole);
    blocks.first[a] = static_cast<int>(first);
  }
  return blocks;
}

std::optional<Image>
on_voxels(const ImageInfo& info, const Specimen& body, int components,
          const std::function<void(std::int64_t cell, std::span<float> values)>& values) {
  const auto blocks = voxel_blocks(info, body);
  if (!blocks)
    return std::nullopt;
  Image image;
  image.info = info;
  image.info.components = components;
  const auto n = static_cast<std::size_t>(info.n_voxels());
  image.values.assign(n * static_cast<std::size_t>(components), 0);
  std::vector<float> of_cell(static_cast<std::size_t>(components));
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    values(cell, of_cell);
    const Index3 at = body.grid.cell_at(cell);
    Index3 low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(0, blocks->first[a] + at[a] * blocks->per_cell[a]);
      high[a] = std::min(blocks->first[a] + (at[a] + 1) * blocks->per_cell[a], info.size[a]);
    }
    for (int k = low[2]; k < high[2]; ++k)
      for (int j = low[1]; j < high[1]; ++j)
        for (int i = low[0]; i < high[0]; ++i) {
          const auto voxel =
              static_cast<std::size_t>(i + std::int64_t{info.size[0]} * (j + std::int64_t{info.size[1]} * k));
          for (std::size_t c = 0; c < of_cell.size(); ++c)
            image.values[c * n + voxel] = of_cell[c];
        }
  }
  return image;
}

namespace {

constexpr std::size_t header_bytes = 352; // 348, and four that say that there are no extensions

/// A NIfTI-1 header in this machine's byte order, which readers find out by its first number.
class Header {
public:
  template<class T>
  void put(std::size_t at, T value) {
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void put(std::size_t at, const char* text) { bytes_.replace(at, std::strlen(text), text); }
  const std::string& bytes() const { return bytes_; }

private:
  std::string bytes_ = std::string(header_bytes, '\0');
};

Header header_of(const ImageInfo& info) {
  constexpr std::int16_t float32 = 16, bits = 32, vector = 1007, symmetric_matrix = 1005, scanner = 1;
  constexpr double millimetres = 1e3;
  constexpr char unit_is_millimetre = 2;
  Header header;
  header.put(0, std::int32_t{348});
  const bool has_components = info.components > 1;
  header.put(40, static_cast<std::int16_t>(has_components ? 5 : 3));
  for (std::size_t a = 0; a < 3; ++a)
    header.put(42 + 2 * a, static_cast<std::int16_t>(info.size[a]));
  header.put(48, std::int16_t{1});
  header.put(50, static_cast<std::int16_t>(info.components));
  header.put(52, std::int16_t{1});
  header.put(54, std::int16_t{1});
  if (info.components == 3)
    header.put(68, vector);
  if (info.components == 6) {
    header.put(56, 3.0F); // intent_p1: of a 3 x 3 matrix
    header.put(68, symmetric_matrix);
  }
  header.put(70, float32);
  header.put(72, bits);
  header.put(108, static_cast<float>(header_bytes));
  header.put(112, 1.0F);
  header.put(123, unit_is_millimetre);
  header.put(252, scanner);
  header.put(254, scanner);
  Eigen::Matrix3d direction;
  Eigen::Vector3d origin;
  for (std::size_t row = 0; row < 3; ++row) {
    const double sign = info.world == WorldAxes::lps && row < 2 ? -1 : 1;
    origin[static_cast<Eigen::Index>(row)] = sign * millimetres * info.origin[row];
    for (std::size_t a = 0; a < 3; ++a)
      direction(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(a)) = sign * info.direction[row][a];
  }
  for (std::size_t row = 0; row < 3; ++row) {
    const auto r = static_cast<Eigen::Index>(row);
    for (std::size_t a = 0; a < 3; ++a)
      header.put(280 + 16 * row + 4 * a, static_cast<float>(direction(r, static_cast<Eigen::Index>(a)) *
                                                            millimetres * info.spacing[a]));
    header.put(280 + 16 * row + 12, static_cast<float>(origin[r]));
    header.put(268 + 4 * row, static_cast<float>(origin[r]));
  }
  const bool is_mirrored = direction.determinant() < 0;
  if (is_mirrored)
    direction.col(2) = -direction.col(2);
  Eigen::Quaterniond turn(direction);
  turn.normalize();
  if (turn.w() < 0)
    turn.coeffs() = -turn.coeffs();
  header.put(76, is_mirrored ? -1.0F : 1.0F);
  for (std::size_t a = 0; a < 3; ++a)
    header.put(80 + 4 * a, static_cast<float>(millimetres * info.spacing[a]));
  header.put(256, static_cast<float>(turn.x()));
  header.put(260, static_cast<float>(turn.y()));
  header.put(264, static_cast<float>(turn.z()));
  header.put(344, "n+1");
  return header;
}

class Output {
public:
  Output(const std::filesystem::path& file, bool is_gzipped) : name_(file.string()) {
    // `T` leaves the bytes as they are.
    file_.reset(gzopen(file.c_str(), is_gzipped ? "wb6" : "wbT"));
    if (!file_)
      fail();
  }
  void write(const void* bytes, std::size_t count) {
    constexpr std::size_t most = std::size_t{1} << 24;
    const char* from = static_cast<const char*>(bytes);
    for (std::size_t done = 0; done < count;) {
      const auto part = static_cast<unsigned>(std::min(most, count - done));
      if (gzwrite(file_.get(), from + done, part) != static_cast<int>(part))
        fail();
      done += part;
    }
  }
  void close() {
    if (gzclose(file_.release()) != Z_OK)
      fail();
  }

private:
  struct Close {
    void operator()(gzFile_s* file) const { gzclose(file); }
  };
  [[noreturn]] void fail() const { throw std::runtime_error("cannot write " + name_); }

  std::string name_;
  std::unique_ptr<gzFile_s, Close> file_;
};

} // namespace

void write_nifti(const Image& image, const std::filesystem::path& file) {
  constexpr int longest_axis = 32767;
  const auto n = static_cast<std::size_t>(image.info.n_voxels());
  if (*std::ranges::max_element(image.info.size) > longest_axis)
    throw std::invalid_argument(fmt::format("NIfTI-1 holds at most {} voxels along an axis", longest_axis));
  if (image.values.size() != n * static_cast<std::size_t>(image.info.components))
    throw std::invalid_argument("an image whose values do not fit its grid");
  const Header header = header_of(image.info);
  Output output(file, file.extension() == ".gz");
  output.write(header.bytes().data(), header_bytes);
  constexpr std::array<std::size_t, 6> symmetric{0, 3, 1, 5, 4, 2};
  for (std::size_t c = 0; c < static_cast<std::size_t>(image.info.components); ++c)
    output.write(image.values.data() + n * (image.info.components == 6 ? symmetric[c] : c),
                 n * sizeof(float));
  output.close();
}

} // namespace maille
