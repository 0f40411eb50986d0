#include "cli/commands.hpp"
#include "cli/help.hpp"
#include "export/whole_file.hpp"
#include "maille/images/image.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/library.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <climits>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

/// Text for a quoted TOML string; invalid UTF-8 is replaced.
std::string escaped(const std::string& text) {
  std::string json = nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = json.find('\x7f'); at != std::string::npos; at = json.find('\x7f', at))
    json.replace(at, 1, "\\u007f");
  return json.substr(1, json.size() - 2);
}

std::string with_name(std::string text, std::string_view key, const std::string& given) {
  const std::string name = escaped(given);
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + name.size()))
    text.replace(at, key.size(), name);
  return text;
}

/// A box around voxels.
struct Extent {
  Index3 low{INT_MAX, INT_MAX, INT_MAX}, high{-1, -1, -1};

  void take(const Index3& at) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  }
  double length(std::size_t axis, const Vec3& spacing) const {
    return (high[axis] - low[axis] + 1) * spacing[axis];
  }
};

struct FoundLabel {
  std::int64_t voxels = 0;
  Extent extent;
  std::string name; ///< name of its segment; may be empty
};

struct LabelImage {
  ImageInfo info;
  std::map<std::int32_t, FoundLabel> labels;
  Extent extent;
  std::int64_t voxels = 0;
};

LabelImage look_at(const fs::path& file) {
  Image image = read_image(file);
  round_labels(image.values);
  LabelImage found;
  found.info = image.info;
  if (image.info.components != 1)
    throw UsageError(fmt::format("{}: expected an image of labels, found {} values a voxel", file.string(),
                                 image.info.components));
  std::size_t voxel = 0;
  for (int k = 0; k < image.info.size[2]; ++k)
    for (int j = 0; j < image.info.size[1]; ++j)
      for (int i = 0; i < image.info.size[0]; ++i, ++voxel) {
        const float value = image.values[voxel];
        if (value == 0)
          continue;
        if (value != std::floor(value) || !(std::abs(value) <= (1 << 24)) || found.labels.size() > 255)
          throw UsageError(
              fmt::format("{}: expected labels, at most 255 whole numbers, found grey values such as {}",
                          file.string(), value));
        FoundLabel& label = found.labels[static_cast<std::int32_t>(value)];
        ++label.voxels;
        label.extent.take({i, j, k});
        ++found.voxels;
        found.extent.take({i, j, k});
      }
  if (found.labels.empty())
    throw UsageError(file.string() + ": expected labels, found voxels of 0 alone");
  for (const NamedSegment& segment : named_segments(file))
    if (const auto label = found.labels.find(segment.label); label != found.labels.end())
      label->second.name = segment.name;
  return found;
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// Tissue of the library for a segment's name; by default any muscle.
std::string tissue_for(const std::string& name) {
  const std::string words = lower(name);
  if (!words.empty())
    for (const LibraryEntry& entry : material_library()) {
      std::string tissue = entry.material.name.substr(entry.material.name.find('/') + 1);
      std::ranges::replace(tissue, '_', ' ');
      if (words.find(tissue) != std::string::npos)
        return entry.material.name;
    }
  return "muscle/soleus";
}

double millilitres(const LabelImage& image, std::int64_t voxels) {
  const Vec3& h = image.info.spacing;
  return 1e6 * h[0] * h[1] * h[2] * static_cast<double>(voxels);
}

/// The body of a scene, and its load axis.
struct Body {
  std::optional<std::int32_t> only; ///< only this label; the others become comments
  std::size_t axis = 0;
};

std::string scene_of(const LabelImage& image, const std::string& file, const std::string& name,
                     const Body& body) {
  constexpr double most_cells = 2e5; // solved in some seconds, for a first picture
  const FoundLabel* const one = body.only ? &image.labels.at(*body.only) : nullptr;
  const double taken = static_cast<double>(one ? one->voxels : image.voxels);
  const int coarsen = std::max(1, static_cast<int>(std::ceil(std::cbrt(taken / most_cells))));
  const double length = (one ? one->extent : image.extent).length(body.axis, image.info.spacing);
  std::array<std::string, 3> fibre{"0", "0", "0"}, by{"0", "0", "0"};
  fibre[body.axis] = "1";
  by[body.axis] = fmt::format("\"{:.3g} mm\"", 1e3 * 0.02 * length);
  std::string text = fmt::format(
      "# A body from {0}.\n# Run it:          maille run {1} --out out\n# Over the scan:   maille run {1} "
      "--warp "
      "--out out\n"
      "# Every key:       docs/scene.md; tissues: maille check library\n\ntitle = \"a body from "
      "{0}\"\n\n[specimen]\n"
      "shape   = \"image\"\nimage   = \"{2}\"\ncoarsen = {3}   # voxels of a cell along each axis\n"
      "fibre   = [{4}]\n\n# Which label is what. Take a line out, and its voxels are no part of the "
      "body.{5}\n"
      "[specimen.labels]\n",
      escaped(fs::path(file).filename().string()), escaped(name), escaped(file), coarsen,
      fmt::join(fibre, ", "),
      one ? "\n# Labels that are held at no end of the body would not move: they are comments here." : "");
  for (const auto& [label, found] : image.labels)
    text +=
        fmt::format("{}{} = \"{}\"   # {} voxels, {:.4g} ml{}\n",
                    body.only && label != *body.only ? "# " : "", label, tissue_for(found.name), found.voxels,
                    millilitres(image, found.voxels), found.name.empty() ? "" : ": " + escaped(found.name));
  text += fmt::format(
      "\n[[hold]]\nwhere = \"{0}-\"   # a face of the box around the body, or a region\n\n[[move]]\n"
      "where = \"{0}+\"\nby    = [{1}]   # 2 % of the body's length\n",
      "xyz"[body.axis], fmt::join(by, ", "));
  return text;
}

/// Axes of the box, the longest first.
std::array<std::size_t, 3> by_length(const Extent& extent, const Vec3& spacing) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  std::ranges::stable_sort(axes, std::greater{}, [&](std::size_t a) { return extent.length(a, spacing); });
  return axes;
}

/// Initial body: all labels, along the longest axis on which nearly all of them are fixed (isolated specks of
/// a segmentation never are); else the largest label.
Body body_to_begin_with(const LabelImage& image, const std::string& file, const fs::path& out) {
  constexpr double specks = 0.01;
  for (const std::size_t axis : by_length(image.extent, image.info.spacing)) {
    try {
      const Scene scene = parse_scene(scene_of(image, file, out.string(), {{}, axis}), out);
      std::int64_t left_out = 0;
      for (const LeftOutPiece& piece : scene.left_out)
        left_out += piece.cells;
      if (static_cast<double>(left_out) <= specks * static_cast<double>(scene.specimen.n_matter_cells()))
        return {{}, axis};
    } catch (const InputError&) { // the moved part is not held anywhere
    }
  }
  const auto largest =
      std::ranges::max_element(image.labels, {}, [](const auto& label) { return label.second.voxels; });
  return {largest->first, by_length(largest->second.extent, image.info.spacing)[0]};
}

void write_new(const fs::path& file, const std::string& text) {
  std::error_code error;
  if (!may_overwrite() && fs::exists(file, error))
    throw UsageError(
        fmt::format("{}: expected no such file, found one; --overwrite replaces it", file.string()));
  prepare_file("--out", file.string(), {}, ".toml");
  write_whole(file, text);
  fmt::print("wrote {}\n", file.string());
}

/// Path of the image relative to the scene's folder.
std::string name_from(const fs::path& folder, const fs::path& image) {
  const fs::path relative =
      fs::absolute(image).lexically_relative(fs::absolute(folder.empty() ? "." : folder));
  return relative.empty() || *relative.begin() == ".." ? fs::absolute(image).string() : relative.string();
}

void new_image(const NewOptions& options) {
  if (options.labels.empty())
    throw UsageError("expected an image of labels: maille new image LABELS.nii.gz");
  const LabelImage image = look_at(options.labels);
  fs::path stem = options.labels.filename();
  while (stem.has_extension())
    stem = stem.stem();
  const fs::path out = options.out ? fs::path(*options.out) : fs::path(stem.string() + ".toml");
  std::string file = name_from(out.parent_path(), options.labels);
  if (file.starts_with('$') || file.starts_with('~')) // protects against expansion of variables and ~
    file.insert(0, "./");
  if (escaped(file).find("\xef\xbf\xbd") != std::string::npos)
    throw UsageError(fmt::format("{}: expected a name in UTF-8, which a scene can hold", file));
  const Body body = body_to_begin_with(image, file, out);
  const std::string text = scene_of(image, file, out.string(), body);
  if (body.only) // the body of all labels is already read
    parse_scene(text, out);
  fmt::print("{:>8} {:>10} {:>12}  {}\n", "label", "voxels", "volume", "name");
  for (const auto& [label, found] : image.labels)
    fmt::print("{:>8} {:>10} {:>9.4g} ml  {}\n", label, found.voxels, millilitres(image, found.voxels),
               for_terminal(found.name));
  if (body.only && image.labels.size() > 1)
    fmt::print(
        "the scene is of label {} alone: the labels together are several bodies, not all of them held\n",
        *body.only);
  write_new(out, text);
}

} // namespace

int new_command(const NewOptions& options) {
  if (options.kind == "image") {
    new_image(options);
    return exit_done;
  }
  if (!options.labels.empty())
    throw UsageError(fmt::format("expected nothing more for a new {}, found \"{}\"", options.kind,
                                 options.labels.string()));
  if (options.kind == "calf") {
    new_calf(options.out.value_or("calf"));
    return exit_done;
  }
  const fs::path out = options.out.value_or(options.kind + ".toml");
  if (options.kind == "strip") {
    write_new(out, with_name(std::string(strip_toml()), "NAME", out.string()));
    return exit_done;
  }
  const fs::path path = out.parent_path() / (out.stem().string() + "_path.toml");
  write_new(path, std::string(path_toml()));
  write_new(out,
            with_name(with_name(std::string(world_toml()), "NAME", out.string()), "PATH", path.string()));
  return exit_done;
}

} // namespace maille::studies
