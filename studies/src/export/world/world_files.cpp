#include "export/world/world_files.hpp"

#include "export/world/world_object_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

/// Converts a name to a part of a file name.
std::string in_file_name(const std::string& name) {
  std::string text;
  for (const char c : name)
    text += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.' ? c : '_';
  return text;
}

/// File names of the objects, all different: non-portable characters become `_`.
std::vector<std::string> names_in_files(const WorldScene& world) {
  std::vector<std::string> names;
  for (const WorldObject& object : world.objects) {
    const std::string plain = in_file_name(object.name);
    std::string name = plain;
    for (int n = 2; std::find(names.begin(), names.end(), name) != names.end(); ++n)
      name = fmt::format("{}-{}", plain, n);
    names.push_back(name);
  }
  return names;
}

} // namespace

WorldSeries::WorldSeries(const WorldScene& world, fs::path stem, std::size_t n_moments,
                         std::string provenance, LengthUnit unit)
    : world_(world), stem_(std::move(stem)),
      n_digits_(std::max(4, static_cast<int>(fmt::formatted_size("{}", n_moments > 0 ? n_moments - 1 : 0)))),
      provenance_(std::move(provenance)), unit_(unit), names_(names_in_files(world)),
      shown_(world.objects.size()) {}

void WorldSeries::add(const WorldMoment& moment) {
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    Shown& shown = shown_[i];
    if (!shown.start)
      shown.start = moment.objects[i];
    if (shown.last != moment.objects[i]) {
      fs::path file = stem_;
      file += fmt::format("_{}_{:0{}}.vtu", names_[i], n_moments_, n_digits_);
      write_world_object(world_, i, moment, *shown.start, provenance_, file, unit_);
      shown.last = moment.objects[i];
      shown.file = file;
      files_.push_back(file);
    }
    entries_.push_back({moment.time, shown.file, static_cast<int>(i)});
  }
  ++n_moments_;
}

fs::path WorldSeries::write() const {
  fs::path pvd = stem_;
  pvd += ".pvd";
  write_pvd(entries_, pvd);
  return pvd;
}

} // namespace maille::studies
