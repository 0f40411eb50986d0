/// The readers that are fuzzed, a function each; target.cpp calls one of them. A reader may return or throw
/// InputError; anything else ends the fuzzer, which is a find.

#include "conditions/places_in_files.hpp"
#include "conditions/voxelise.hpp"
#include "maille/deform/probe/device.hpp"
#include "maille/images/image.hpp"
#include "maille/live/live.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/json.hpp"
#include "maille/materials/library.hpp"
#include "maille/scene/look.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/voxel_map.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "picture/read_picture.hpp"
#include "study/plan/study.hpp"
#include "study/plan/study_table.hpp"
#include "support/temporary_folder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace maille::fuzzing {

namespace {

/// Where files lie that inputs may name: MAILLE_FIXTURES.
const std::filesystem::path& fixtures() {
  static const std::filesystem::path folder = MAILLE_FIXTURES;
  return folder;
}

void require(bool holds, const char* what) {
  if (holds)
    return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

/// Every fault says what was expected and what was found.
void check(const InputError& error) {
  require(!error.faults().empty() && *error.what() != '\0', "an InputError has faults");
  for (const Fault& fault : error.faults())
    require(!fault.file.empty() && !fault.expected.empty() && !fault.found.empty(),
            "a fault says what is wrong");
}

/// Reads what `read` reads. @return 0, as libFuzzer wants it, unless something else than faults comes out
template<class Read>
int tried(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    check(error);
  }
  return 0;
}

/// A file of this process for readers that take no text, written anew for every input.
class ScratchFile {
public:
  explicit ScratchFile(std::string name) : name_(std::move(name)) {}
  std::filesystem::path holding(std::string_view bytes) const { return folder_.write(name_, bytes); }

private:
  test::TemporaryFolder folder_;
  std::string name_;
};

/// Reads an image, and holds what it promises against what came of it. @return see tried
int read_one_image(const std::filesystem::path& file) {
  constexpr std::int64_t largest = 1 << 20;
  return tried([&] {
    const Image image = read_image(file, {largest});
    const ImageInfo& info = image.info;
    require(static_cast<std::int64_t>(image.values.size()) == info.n_voxels() * info.components,
            "as many values as the header says");
    require(static_cast<std::int64_t>(image.values.size() * sizeof(float)) <= largest,
            "no more than was allowed");
    for (std::size_t axis = 0; axis < 3; ++axis)
      require(info.size[axis] > 0 && std::isfinite(info.spacing[axis]) && info.spacing[axis] > 0 &&
                  std::isfinite(info.origin[axis]),
              "a grid that is one");
  });
}

bool is_finite(const Vec3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

void check_scene(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  for (int axis = 0; axis < grid.dimension(); ++axis)
    require(grid.cells()[static_cast<std::size_t>(axis)] > 0 &&
                std::isfinite(grid.spacing()[static_cast<std::size_t>(axis)]) &&
                grid.spacing()[static_cast<std::size_t>(axis)] > 0,
            "a grid that is one");
  require(!scene.materials.empty() && scene.specimen.n_matter_cells() > 0, "a body");
  require(scene.specimen.material_id.empty() ||
              static_cast<std::int64_t>(scene.specimen.material_id.size()) == grid.n_cells(),
          "a material for every cell");
  for (const auto& prescribed : scene.prescribed)
    require(prescribed.node >= 0 && prescribed.node < grid.n_nodes() && prescribed.component >= 0 &&
                prescribed.component < grid.dimension() && std::isfinite(prescribed.value),
            "prescribed components of nodes that there are");
}

void check_world(const WorldScene& world) {
  require(!world.objects.empty(), "objects");
  for (std::size_t axis = 0; axis < 3; ++axis)
    require(world.cells[axis] > 0 && world.spacing[axis] > 0 && std::isfinite(world.spacing[axis]), "cells");
  require(std::isfinite(world.friction) && world.friction >= 0, "a coefficient of friction");
  require(!world.frame_budget || *world.frame_budget > 0, "a budget that is one");
  std::set<std::string> names;
  for (const WorldObject& object : world.objects) {
    require(!object.name.empty() && names.insert(object.name).second, "a name for every object");
    require(object.scene.dimension() == world.dimension, "objects of the world's dimension");
    require(object.scene.specimen.n_matter_cells() > 0, "a body for every object");
    require(is_finite(object.position) && is_finite(object.turn_axis) && std::isfinite(object.turn_angle),
            "a place for every object");
    require(object.kind != ObjectKind::deformable || !object.scene.materials.empty(),
            "something that gives way");
  }
}

void check_trajectory(const Trajectory& path, const WorldScene& world) {
  require(std::isfinite(path.frame_seconds) && path.frame_seconds > 0, "frames that take time");
  for (const DriveSpan& span : path.spans) {
    require(span.object < world.objects.size(), "drives of objects that there are");
    const WorldObject& object = world.objects[span.object];
    require(object.kind != ObjectKind::fixed, "drives of what can move");
    for (const std::int64_t node : std::vector<std::int64_t>(span.nodes))
      require(node >= 0 && node < object.scene.specimen.grid.n_nodes(), "nodes that there are");
    require(span.first_frame >= 1 && span.n_frames >= 1 && span.end_frame() - 1 <= path.n_frames,
            "frames that there are");
    require(is_finite(span.by) && (!span.to || is_finite(*span.to)) && is_finite(span.axis) &&
                std::isfinite(span.angle) && (!span.about || is_finite(*span.about)),
            "movements that are finite");
  }
}

} // namespace

/// Files that hold one material, as `maille fit` writes them.
int read_material(std::string_view text) {
  set_file_scope(FileScope::sandbox); // what is tried reads nothing but fixtures
  static const ScratchFile file("material.toml");
  const auto folder = file.holding(text).parent_path();
  return tried([&] {
    const Scene scene = parse_scene("[specimen]\nshape = \"box\"\ncells = [2, 2, 2]\nspacing = \"1 mm\"\n"
                                    "material = \"material.toml\"\n[[hold]]\nwhere = \"x-\"\n",
                                    folder / "scene.toml");
    require(violated_inequalities(scene.materials.at(0).elasticity).empty(), "positive strain energy");
  });
}

/// Files of the tissue library.
int read_tissue(std::string_view text) {
  return tried([&] {
    const LibraryEntry entry = parse_library_entry(text, "tissue.toml", "a/tissue");
    require(violated_inequalities(entry.material.elasticity).empty(), "positive strain energy");
  });
}

/// MetaImage.
int read_meta_image(std::string_view text) {
  static const ScratchFile file("a.mha");
  return read_one_image(file.holding(text));
}

/// NIfTI, packed (.nii.gz) where the input is a gzip file and plain otherwise.
int read_nifti(std::string_view text) {
  static const ScratchFile plain("a.nii"), packed("a.nii.gz");
  return read_one_image((text.starts_with("\x1f\x8b") ? packed : plain).holding(text));
}

/// NRRD, and what its keys call segments.
int read_nrrd(std::string_view text) {
  static const ScratchFile file("a.seg.nrrd");
  const auto path = file.holding(text);
  tried([&] { require(named_segments(path).size() <= 10'000, "no more segments than are looked for"); });
  return read_one_image(path);
}

/// Headers of a DICOM series, as the process that reads the files hands them over (small_machine.cpp).
int read_dicom(std::string_view text) {
  constexpr std::size_t bytes_of_header = 128, most_slices = 8;
  static const test::TemporaryFolder folder;
  std::filesystem::remove_all(folder / "series");
  std::filesystem::create_directory(folder / "series");
  for (std::size_t n = 0; n < most_slices && n * bytes_of_header < text.size(); ++n)
    folder.write("series/" + std::to_string(n), text.substr(n * bytes_of_header, bytes_of_header));
  return read_one_image(folder / "series");
}

/// VTK's image data.
int read_vti(std::string_view text) {
  static const ScratchFile file("a.vti");
  return read_one_image(file.holding(text));
}

/// Landmarks of 3D Slicer: JSON where the input begins as that, else .fcsv.
int read_landmarks(std::string_view text) {
  static const ScratchFile table("a.fcsv"), json("a.mrk.json");
  return tried([&] {
    const auto landmarks = reader::read_landmarks((text.starts_with("{") ? json : table).holding(text));
    require(!landmarks.points.empty() && landmarks.names.size() == landmarks.points.size(),
            "points with names");
    for (const Vec3& point : landmarks.points)
      require(is_finite(point), "points that are finite");
  });
}

/// Surfaces of triangles, STL.
int read_surface(std::string_view text) {
  static const ScratchFile file("a.stl");
  return tried([&] {
    const auto mesh = reader::read_stl(file.holding(text));
    require(!mesh.triangles.empty(), "triangles");
    for (const auto& triangle : mesh.triangles) {
      for (const Vec3& corner : triangle)
        require(is_finite(corner), "corners that are finite");
      require(reader::distance({0, 0, 0}, triangle) >= 0, "a distance");
    }
  });
}

/// Surfaces, OBJ, and the voxels inside where they are closed.
int read_obj(std::string_view text) {
  static const ScratchFile file("a.obj");
  return tried([&] {
    const auto mesh = reader::read_obj(file.holding(text));
    require(!mesh.triangles.empty(), "triangles");
    const Vec3 spacing{1, 1, 1};
    const auto n = reader::voxels_of({mesh.triangles}, spacing);
    if (n[0] * n[1] * n[2] > 1e5 || mesh.triangles.size() > 1000)
      return;
    const auto made = reader::voxelised({mesh.triangles}, spacing);
    if (const auto* image = std::get_if<Image>(&made))
      require(static_cast<std::int64_t>(image->values.size()) == image->info.n_voxels(), "a value a voxel");
  });
}

/// Scenes. Those without fault are looked at once more: what methods are given has to be what they are
/// promised.
int read_scene(std::string_view text) {
  set_file_scope(FileScope::sandbox); // what is tried reads nothing but fixtures
  return tried([&] { check_scene(parse_scene(text, fixtures() / "scene.toml")); });
}

/// Scenes of worlds. Those without fault are looked at once more: objects of the world's dimension, with
/// names that tell them apart.
int read_world(std::string_view text) {
  set_file_scope(FileScope::sandbox); // what is tried reads nothing but fixtures
  return tried([&] { check_world(parse_world_scene(text, fixtures() / "scene.toml")); });
}

/// Trajectories, as TOML and, where they begin with the names of columns, as tables, for a world of a rigid
/// and a deformable object.
int read_trajectory(std::string_view text) {
  static const WorldScene world = read_world_scene(fixtures() / "world.toml");
  const bool is_table = text.starts_with("frame,");
  return tried(
      [&] { check_trajectory(parse_trajectory(text, is_table ? "path.csv" : "path.toml", world), world); });
}

/// Recorded motions of a hand.
int read_recorded_motion(std::string_view text) {
  return tried([&] {
    const auto motion = deform::parse_recorded_motion(text);
    require(!motion.samples().empty(), "samples");
    double before = -std::numeric_limits<double>::infinity();
    for (const auto& sample : motion.samples()) {
      require(std::isfinite(sample.time) && sample.time > before, "times that rise");
      before = sample.time;
      for (const double time : {sample.time, (sample.time + motion.duration()) / 2})
        for (const double x : motion.at(time).position)
          require(std::isfinite(x), "places that are finite");
    }
  });
}

/// Studies, over the scenes among the fixtures, and the scenes of their first cases.
int read_study(std::string_view text) {
  set_file_scope(FileScope::sandbox); // what is tried reads nothing but fixtures
  return tried([&] {
    const auto study = studies::parse_study(text, fixtures() / "study.toml");
    require(!study.scenes.empty() && !study.methods.empty(), "scenes and methods");
    require(studies::n_cases(study) <= 1'000'000, "no more cases than is said");
    if (studies::n_cases(study) > 1000)
      return; // all alike
    const auto cases = studies::cases(study);
    require(static_cast<std::int64_t>(cases.size()) == studies::n_cases(study),
            "as many cases as are counted");
    for (std::size_t i = 0; i < cases.size() && i < 3; ++i)
      require(!studies::resolved_scene(study, cases[i]).empty(), "a scene for every case");
  });
}

/// Tables of studies, which --resume and merge read: JSON lines. What is read is written and read again.
int read_study_table(std::string_view text) {
  set_file_scope(FileScope::sandbox); // what is tried reads nothing but fixtures
  return tried([&] {
    for (const studies::StudyRow& row : studies::parse_study_table(text, "table.jsonl").rows) {
      const std::string line = studies::json_line(row);
      const auto again = studies::parse_study_table(line + "\n", "table.jsonl").rows;
      require(studies::json_line(again.at(0)) == line, "rows read back as they were");
    }
  });
}

/// JSON: lists of results, tables of studies, what `report` shows.
int read_json(std::string_view text) {
  return tried([&] {
    const auto json = parse_json(text, "list.json");
    require(parse_json(json.dump(), "list.json") == json, "values that read back as they were");
  });
}

/// Colour maps of ParaView.
int read_colour_map(std::string_view text) {
  static const ScratchFile file("map.json");
  return tried([&] {
    const Look look = read_paraview_colours(file.holding(text));
    require(!look.colours.empty() && !look.opacity.empty(), "colours and opacity");
  });
}

/// Looks of a scene.
int read_look(std::string_view text) {
  set_file_scope(FileScope::sandbox);
  static const ScratchFile file("looks.toml");
  return tried([&] { read_looks(file.holding(text)); });
}

/// Pictures in PNG.
int read_picture(std::string_view text) {
  return tried([&] {
    const auto picture = studies::read_png(text, "a.png");
    require(picture.rgb.size() == std::size_t{3} * static_cast<std::size_t>(picture.width) *
                                      static_cast<std::size_t>(picture.height),
            "three bytes a pixel");
  });
}

/// Pictures in JPEG.
int read_jpeg(std::string_view text) {
  static const ScratchFile file("a.jpg");
  return tried([&] {
    const auto picture = studies::read_picture(file.holding(text));
    require(picture.width > 0 && picture.height > 0 &&
                picture.rgb.size() == std::size_t{3} * static_cast<std::size_t>(picture.width) *
                                          static_cast<std::size_t>(picture.height),
            "three bytes a pixel");
  });
}

/// Arrays of results that VTK's writers wrote (.vti, .vtu), on eight nodes.
int read_field_file(std::string_view text) {
  static const ScratchFile file("a.vti");
  return tried([&] {
    const auto path = file.holding(text);
    const VtkArrays arrays = read_vtk_arrays(path, {"Displacement"}, 8);
    const auto& values = arrays.at_nodes.at("Displacement");
    require(values.empty() || std::ssize(values) % std::max(arrays.points, 1L) == 0, "numbers at each node");
  });
}

/// Events of a window.
int read_events(std::string_view text) {
  return tried([&] {
    double before = 0;
    for (const auto& event : live::parse_script(text, "events.csv")) {
      require(event.at >= before, "times that do not fall");
      before = event.at;
    }
  });
}

} // namespace maille::fuzzing
