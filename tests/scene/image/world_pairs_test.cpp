/// The same image in every format, its axes stored in any order and direction, is in the same place,
/// whatever it is read for. Files are written here, byte by byte, from one grid along right, anterior,
/// superior.
#include "maille/scene/read_scene.hpp"
#include "maille/scene/voxel_map.hpp"
#include "maille/scene/warp/warp.hpp"
#include "scene/image/image_writers.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

using image_tests::bytes_of;

/// Axes [mm] and origin along right, anterior, superior; values by voxel and component.
struct Stored {
  Index3 size{5, 4, 6};
  std::array<Vec3, 3> axis{};
  Vec3 origin{-18, 31, 7};
  int components = 1;
  std::function<double(const Index3&, int)> value;
};

/// Oblique, with three spacings.
Stored oblique() {
  const double c = std::cos(0.3), s = std::sin(0.3);
  Stored image;
  image.axis = {
      {{1.5 * c, 1.5 * s, 0}, {-2 * s * c, 2 * c * c, 2 * s}, {2.5 * s * s, -2.5 * c * s, 2.5 * c}}};
  return image;
}

struct Order {
  std::array<std::size_t, 3> axis{0, 1, 2};
  std::array<bool, 3> is_reversed{};
};

Stored reordered(const Stored& from, const Order& order) {
  Stored to = from;
  for (std::size_t b = 0; b < 3; ++b) {
    const std::size_t a = order.axis[b];
    to.size[b] = from.size[a];
    for (std::size_t r = 0; r < 3; ++r) {
      to.axis[b][r] = order.is_reversed[b] ? -from.axis[a][r] : from.axis[a][r];
      to.origin[r] += order.is_reversed[b] ? from.axis[a][r] * (from.size[a] - 1) : 0;
    }
  }
  to.value = [from, order](const Index3& at, int component) {
    Index3 of{};
    for (std::size_t b = 0; b < 3; ++b)
      of[order.axis[b]] = order.is_reversed[b] ? from.size[order.axis[b]] - 1 - at[b] : at[b];
    return from.value(of, component);
  };
  return to;
}

template<class T>
std::string data_of(const Stored& image, bool component_fastest) {
  std::string bytes;
  for (const auto& [j, k, c] :
       test::all_below({image.size[1], image.size[2], (component_fastest ? 1 : image.components)}))
    for (int i = 0; i < image.size[0]; ++i)
      for (int d = 0; d < (component_fastest ? image.components : 1); ++d)
        bytes += bytes_of(static_cast<T>(image.value({i, j, k}, c + d)), false);
  return bytes;
}

std::string three(const Vec3& v, double factor, const char* between) {
  return fmt::format("{:.12g}{}{:.12g}{}{:.12g}", -factor * v[0], between, -factor * v[1], between,
                     factor * v[2]);
}

double length(const Vec3& v) {
  return std::hypot(v[0], v[1], v[2]);
}

std::string dicom_element(int group, int element, const std::string& type, std::string value) {
  value += value.size() % 2 != 0 ? " " : "";
  const bool is_long = type == "OW";
  return bytes_of(std::uint16_t(group), false) + bytes_of(std::uint16_t(element), false) + type +
         (is_long ? std::string(2, '\0') + bytes_of(std::uint32_t(value.size()), false)
                  : bytes_of(std::uint16_t(value.size()), false)) +
         value;
}

std::string write_dicom(const image_tests::TemporaryFolder& folder, const std::string& name,
                        const Stored& image) {
  for (int k = 0; k < image.size[2]; ++k) {
    Stored slice = image;
    slice.size[2] = 1;
    for (std::size_t r = 0; r < 3; ++r)
      slice.origin[r] += k * image.axis[2][r];
    slice.value = [&](const Index3& at, int) { return image.value({at[0], at[1], k}, 0); };
    const auto number = [](int n) { return bytes_of(std::uint16_t(n), false); };
    const std::string syntax = dicom_element(2, 0x10, "UI", std::string("1.2.840.10008.1.2.1\0", 20));
    folder.write(
        name + fmt::format("/IM{}", 90 - k),
        std::string(128, '\0') + "DICM" +
            dicom_element(2, 0, "UL", bytes_of(std::uint32_t(syntax.size()), false)) + syntax +
            dicom_element(8, 0x60, "CS", "CT") + dicom_element(0x18, 0x50, "DS", "2.5") +
            dicom_element(0x20, 0x0e, "UI", "1.2.3.44") +
            dicom_element(0x20, 0x32, "DS", three(slice.origin, 1, "\\")) +
            dicom_element(0x20, 0x37, "DS",
                          three(image.axis[0], 1 / length(image.axis[0]), "\\") + "\\" +
                              three(image.axis[1], 1 / length(image.axis[1]), "\\")) +
            dicom_element(0x28, 2, "US", number(1)) + dicom_element(0x28, 4, "CS", "MONOCHROME2") +
            dicom_element(0x28, 0x10, "US", number(image.size[1])) +
            dicom_element(0x28, 0x11, "US", number(image.size[0])) +
            dicom_element(0x28, 0x30, "DS",
                          fmt::format("{:.10g}\\{:.10g}", length(image.axis[1]), length(image.axis[0]))) +
            dicom_element(0x28, 0x100, "US", number(16)) + dicom_element(0x28, 0x101, "US", number(16)) +
            dicom_element(0x28, 0x102, "US", number(15)) + dicom_element(0x28, 0x103, "US", number(1)) +
            dicom_element(0x7fe0, 0x10, "OW", data_of<std::int16_t>(slice, true)));
  }
  return name;
}

/// @param vectors_in_lps  stated so by NIfTI's intent 1007 and NRRD's kind `vector`
std::string write(const image_tests::TemporaryFolder& folder, const std::string& format,
                  const std::string& stem, Stored image) {
  const bool is_field = image.components == 3;
  if (is_field && (format == "nii" || format == "nrrd"))
    image.value = [of = image.value](const Index3& at, int c) { return c < 2 ? -of(at, c) : of(at, c); };
  const auto& [x, y, z] = image.axis;
  const std::string sizes = fmt::format("{} {} {}", image.size[0], image.size[1], image.size[2]);
  if (format == "dicom")
    return write_dicom(folder, stem, image);
  std::string text;
  if (format == "nii") {
    image_tests::NiftiFile file{.datatype = 16, .bitpix = 32, .sform = 1};
    file.dim = {5, image.size[0], image.size[1], image.size[2], 1, image.components};
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t a = 0; a < 4; ++a)
        file.srow[4 * r + a] = a < 3 ? image.axis[a][r] : image.origin[r];
    file.data = data_of<float>(image, false);
    text = file.bytes();
    text.replace(68, 2, bytes_of(std::int16_t(is_field ? 1007 : 0), false));
  } else if (format == "mha") {
    text =
        fmt::format("ObjectType = Image\nNDims = 3\nTransformMatrix = {} {} {}\nOffset = {}\n"
                    "AnatomicalOrientation = RAI\nElementSpacing = {:.12g} {:.12g} {:.12g}\nDimSize = {}\n"
                    "ElementNumberOfChannels = {}\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n",
                    three(x, 1 / length(x), " "), three(y, 1 / length(y), " "), three(z, 1 / length(z), " "),
                    three(image.origin, 1, " "), length(x), length(y), length(z), sizes, image.components) +
        data_of<float>(image, true);
  } else if (format == "nrrd") {
    const bool is_many = image.components > 1;
    text = fmt::format("NRRD0005\ntype: float\ndimension: {}\nspace: left-posterior-superior\nsizes: {}{}\n"
                       "space directions: {}({}) ({}) ({})\nkinds: {}domain domain domain\nendian: little\n"
                       "encoding: raw\nspace origin: ({})\n\n",
                       is_many ? 4 : 3, is_many ? fmt::format("{} ", image.components) : "", sizes,
                       is_many ? "none " : "", three(x, 1, ","), three(y, 1, ","), three(z, 1, ","),
                       is_field  ? "vector "
                       : is_many ? "list "
                                 : "",
                       three(image.origin, 1, ",")) +
           data_of<float>(image, true);
  } else {
    std::string values;
    for (const auto& [i, j, k] : test::all_below(image.size))
      for (int c = 0; c < image.components; ++c)
        values += fmt::format("{:.9g} ", image.value({i, j, k}, c));
    const std::string extent =
        fmt::format("0 {} 0 {} 0 {}", image.size[0] - 1, image.size[1] - 1, image.size[2] - 1);
    std::string rows;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t a = 0; a < 3; ++a)
        rows += fmt::format("{:.12g} ", (r < 2 ? -1 : 1) * image.axis[a][r] / length(image.axis[a]));
    text = fmt::format(
        R"(<VTKFile type="ImageData" byte_order="LittleEndian"><ImageData WholeExtent="{}" Origin="{}" Spacing="{:.12g} {:.12g} {:.12g}" Direction="{}"><Piece Extent="{}"><PointData><DataArray type="Float32" Name="a" NumberOfComponents="{}" format="ascii">{}</DataArray></PointData></Piece></ImageData></VTKFile>)",
        extent, three(image.origin, 1, " "), length(x), length(y), length(z), rows, extent, image.components,
        values);
  }
  folder.write(stem + "." + format, text);
  return stem + "." + format;
}

std::string scene_of(const std::string& labels, const std::string& specimen, const std::string& rest) {
  return "[specimen]\nshape = \"image\"\nimage = \"" + labels +
         "\"\nlabels = { 1 = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }, 2 = \"fat/subcutaneous\" "
         "}\n" +
         specimen + "\n" + rest;
}

/// The value at each place of the grid along right, anterior, superior that an image has.
std::map<std::array<int, 3>, double> by_place(const ImageInfo& of,
                                              const std::function<double(std::int64_t)>& value) {
  const ImageInfo info = in_world(of, WorldAxes::ras);
  std::map<std::array<int, 3>, double> places;
  for (std::int64_t voxel = 0; voxel < info.n_voxels(); ++voxel) {
    const Vec3 at{double(voxel % info.size[0]), double(voxel / info.size[0] % info.size[1]),
                  double(voxel / info.size[0] / info.size[1])};
    std::array<int, 3> place{};
    for (std::size_t r = 0; r < 3; ++r) {
      double x = info.origin[r];
      for (std::size_t a = 0; a < 3; ++a)
        x += info.direction[r][a] * info.spacing[a] * at[a];
      place[r] = int(std::lround(1e4 * x)); // tenths of a millimetre
    }
    places[place] = value(voxel);
  }
  return places;
}

class WorldPairs {
public:
  explicit WorldPairs(unsigned seed) : random_(seed) {
    for (float& value : noise_)
      value = float(random_() % 1000) / 1000;
    std::shuffle(order_.axis.begin(), order_.axis.end(), random_);
    for (bool& is_reversed : order_.is_reversed)
      is_reversed = random_() % 2 == 0;
    body_ = write(folder_, "nii", "body", labels());
  }
  /// Whether what is read is what NIfTI gives in its plain order.
  bool is_right(const std::string& kind, const std::string& format) {
    if (kind == "labels" || kind == "maps" || kind == "scan")
      return places(kind, write(folder_, format, "l", reordered(labels(), order_))) ==
             places("labels", body_);
    const Stored second = kind == "mask"        ? labels()
                          : kind == "stiffness" ? noisy(1, 1)
                          : kind == "field"     ? noisy(3, -0.5)
                                                : tensors();
    Stored turned = reordered(second, order_);
    if (kind == "tensor")
      turned.value = [this, of = turned.value](const Index3& at, int c) {
        constexpr std::array<std::array<std::size_t, 2>, 6> index{
            {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
        const auto [p, q] = index[std::size_t(c)];
        const std::size_t a = order_.axis[p], b = order_.axis[q];
        for (int d = 0; d < 6; ++d)
          if (const auto [r, s] = index[std::size_t(d)]; (r == a && s == b) || (r == b && s == a))
            return (order_.is_reversed[p] != order_.is_reversed[q] ? -1 : 1) * of(at, d);
        return 0.0;
      };
    const auto one = numbers(kind, write(folder_, "nii", "one", second)),
               other = numbers(kind, write(folder_, format, "two", turned));
    bool is_same = one.size() == other.size() && !one.empty();
    for (std::size_t i = 0; is_same && i < one.size(); ++i)
      is_same = std::abs(one[i] - other[i]) <= 1e-4 * (0.1 + std::abs(one[i]));
    return is_same;
  }

private:
  Stored noisy(int components, double offset) const {
    Stored image = oblique();
    image.components = components;
    image.value = [this, offset, n = image.size](const Index3& at, int c) {
      return offset + double{noise_[std::size_t(at[0] + n[0] * (at[1] + n[1] * (at[2] + n[2] * c)))]};
    };
    return image;
  }
  Stored labels() const {
    Stored image = noisy(1, 0);
    image.value = [of = image.value](const Index3& at, int) { return of(at, 0) < 0.6 ? 1.0 : 2.0; };
    return image;
  }
  Stored tensors() const {
    Stored image = noisy(6, -0.5);
    image.value = [of = image.value](const Index3& at, int c) { return c < 3 ? 3 + of(at, c) : of(at, c); };
    return image;
  }
  Scene read(const std::string& text) const { return parse_scene(text, folder_.path() / "s.toml"); }
  std::map<std::array<int, 3>, double> places(const std::string& kind, const std::string& file) const {
    const std::filesystem::path path = folder_.path() / file;
    const ImageInfo info = read_image_info(path);
    if (kind == "scan") {
      const Scene scene = read(scene_of(body_, "", "[[hold]]\nwhere = \"z-\""));
      const Displacement none(scene.specimen.grid);
      const std::vector<DeformedBody> bodies{{&scene.specimen, &none}};
      const Image seen = warped(pull_of(info, bodies), read_image(path), -1);
      return by_place(seen.info, [&](std::int64_t voxel) { return double{seen.values[std::size_t(voxel)]}; });
    }
    const Specimen body = read(scene_of(file, "", "[[hold]]\nwhere = \"z-\"")).specimen;
    if (kind == "labels")
      return by_place(info, [&](std::int64_t voxel) { return double(body.label[std::size_t(voxel)]); });
    const auto map = on_voxels(info, body, 1, [&](std::int64_t cell, std::span<float> value) {
      value[0] = float(body.label[std::size_t(cell)]);
    });
    write_nifti(*map, folder_.path() / "map.nii");
    const Image back = read_image(folder_.path() / "map.nii");
    return by_place(back.info, [&](std::int64_t voxel) { return double{back.values[std::size_t(voxel)]}; });
  }
  std::vector<double> numbers(const std::string& kind, const std::string& file) const {
    const std::string hold = "[[hold]]\nwhere = \"z-\"\n";
    std::vector<double> found;
    if (kind == "stiffness") {
      const Scene scene =
          read(scene_of(body_, "stiffness = { image = \"" + file + "\", unit = \"kPa\" }", hold));
      found.assign(scene.specimen.stiffness_ratio.begin(), scene.specimen.stiffness_ratio.end());
    } else if (kind == "tensor") {
      const Scene scene = read(scene_of(body_, "fibre = { tensor_image = \"" + file + "\" }", hold));
      for (const auto& f : scene.specimen.fibres)
        for (std::size_t a = 0; a < 3; ++a)
          for (std::size_t b = 0; b <= a; ++b)
            found.push_back(double{f[a]} * double{f[b]});
    } else {
      const Scene scene =
          kind == "mask"
              ? read(scene_of(body_, "", "[[hold]]\nwhere = { image = \"" + file + "\", value = 2 }\n"))
              : read(scene_of(body_, "",
                              hold + "[[move]]\nwhere = \"z+\"\nframe = \"ras\"\nfield = { image = \"" +
                                  file + "\" }\n"));
      for (const Prescribed& p : scene.prescribed)
        found.insert(found.end(), {double(p.node), double(p.component), p.value});
    }
    return found;
  }

  std::mt19937 random_;
  image_tests::TemporaryFolder folder_;
  std::array<float, 5 * 4 * 6 * 6> noise_{};
  Order order_;
  std::string body_;
};

// Truth: one grid, whose voxels each format places by its own definition.
TEST(WorldPairsOracle, EveryFormatIsInOnePlace) {
  int n = 0, wrong = 0;
  for (unsigned seed = 0; seed < 12; ++seed)
    for (const char* kind : {"mask", "field", "tensor", "stiffness", "labels", "scan", "maps"})
      for (const char* format : {"nii", "nrrd", "mha", "dicom", "vti"}) {
        if (std::string(format) == "dicom" && kind != std::string("mask") && kind != std::string("labels") &&
            kind != std::string("scan") && kind != std::string("maps"))
          continue; // which holds whole numbers, one a voxel
        WorldPairs pairs(seed);
        bool is_right = false;
        EXPECT_NO_THROW(is_right = pairs.is_right(kind, format)) << kind << " " << format << " " << seed;
        EXPECT_TRUE(is_right) << kind << " " << format << " " << seed;
        wrong += is_right ? 0 : 1;
        ++n;
      }
  std::cout << "world_pairs_wrong " << wrong << " of " << n << "\n";
}

} // namespace
} // namespace maille
