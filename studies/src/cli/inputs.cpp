#include "inputs.hpp"

#include "cli/commands.hpp"
#include "export/whole_file.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "picture/question_picture.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <iterator>
#include <span>
#include <string_view>

namespace maille::studies {

namespace {

/// All files that were opened since the first input was named.
const OpenedFiles& opened_files() {
  static const OpenedFiles opened;
  return opened;
}

} // namespace

void keep_inputs(const std::vector<std::filesystem::path>& files) {
  opened_files();
  for (const std::filesystem::path& file : files)
    keep_input(file);
}

namespace {

constexpr const char* failed = "failed";
bool have_met = false; ///< ranks have compared their data

template<class T>
std::uint64_t hash_of(const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return std::hash<std::string_view>{}({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string hash_of_opened_files() {
  std::vector<std::uint64_t> sums; // sorted: names may differ between machines
  std::string part(std::size_t{1} << 20, '\0');
  for (const std::filesystem::path& file : opened_files().files()) {
    std::uint64_t& sum = sums.emplace_back(0);
    std::ifstream stream(file, std::ios::binary);
    do {
      stream.read(part.data(), std::ssize(part));
      const auto size = static_cast<std::string::size_type>(stream.gcount());
      sum = sum * 0x100000001b3U + std::hash<std::string_view>{}({part.data(), size});
    } while (stream);
  }
  std::ranges::sort(sums);
  return fmt::format("{} {:x}", sums.size(), hash_of(sums));
}

/// Texts of all ranks, by rank.
std::vector<std::string> said_by_all(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  const std::vector<std::byte> own(bytes.begin(), bytes.end());
  std::vector<std::string> all;
  for (const auto& one : fem_ref::exchange({static_cast<unsigned>(fem_ref::ranks().size), own}))
    all.emplace_back(reinterpret_cast<const char*>(one.data()), one.size());
  return all;
}

} // namespace

bool ranks_agree(const Digests& digests) {
  if (fem_ref::ranks().size == 1)
    return true;
  const auto said =
      said_by_all(nlohmann::json(digests).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  const auto first = std::ranges::find_if(said, [](const std::string& text) { return text != failed; });
  const auto other =
      std::ranges::find_if(said, [&](const std::string& text) { return text != failed && text != *first; });
  const bool is_speaker = first - said.begin() == fem_ref::ranks().rank;
  if (other != said.end() && is_speaker) {
    const auto theirs = nlohmann::json::parse(*other).get<Digests>();
    std::string what;
    for (std::size_t i = 0; i < digests.size(); ++i)
      if (theirs.at(i) != digests[i])
        what += (what.empty() ? "" : ", ") + digests[i].first;
    fmt::print(stderr, "maille: expected the same on all ranks, found that rank {} differs in its {}\n",
               other - said.begin(), what);
  }
  return other == said.end() && std::ranges::find(said, failed) == said.end();
}

bool ranks_agree_on(const Scene* scene, const std::string& options) {
  if (fem_ref::ranks().size == 1)
    return true;
  have_met = true;
  std::string body;
  if (scene != nullptr)
    body = fmt::format("{} {:x} {:x} {}", fmt::join(scene->specimen.grid.cells(), " "),
                       hash_of(scene->specimen.material_id), hash_of(scene->specimen.label),
                       fmt::join(scene->specimen.grid.spacing(), " "));
  return ranks_agree({{"options", options}, {"scene", hash_of_opened_files()}, {"body", body}});
}

void meet_no_more() {
  have_met = true;
}

bool have_all_met() {
  return have_met && fem_ref::ranks().size > 1;
}

bool reports_failure() {
  if (std::exchange(have_met, true) || fem_ref::ranks().size == 1)
    return fem_ref::ranks().is_first();
  const auto said = said_by_all(failed);
  return fem_ref::ranks().is_first() ||
         std::ranges::any_of(said, [](const std::string& text) { return text != failed; });
}

std::map<std::string, std::string> digests_of_opened_files() {
  std::map<std::string, std::string> digests;
  for (const std::filesystem::path& file : opened_files().files()) {
    std::error_code none; // a link leads to its file, a pipe to none: it cannot be read twice
    const std::string digest = digest_of(std::filesystem::weakly_canonical(file, none));
    if (digest.empty() && std::filesystem::is_regular_file(file) && !std::filesystem::is_empty(file))
      throw InputError(
          {{file.string(), 0, "", "a file that stays readable", "an error while it was read again"}});
    digests.emplace(file.lexically_normal().string(), digest);
  }
  return digests;
}

std::string scene_text_of(const std::filesystem::path& file) {
  try {
    return read_text_file(file, "a scene file");
  } catch (const InputError&) {
    return {};
  }
}

bool is_of_a_patient(const std::filesystem::path& scene) {
  try {
    return is_scene_of_a_patient(read_text_file(scene, "a scene file"));
  } catch (const InputError&) {
    return false;
  }
}

namespace {

std::int64_t count(const WorldScene& scene, ObjectKind kind) {
  return std::ranges::count(scene.objects, kind, &WorldObject::kind);
}

std::string cells_in_words(const WorldScene& scene) {
  std::string text = fmt::format("{}", scene.cells[0]);
  for (int a = 1; a < scene.dimension; ++a)
    text += fmt::format(" x {}", scene.cells[a]);
  return text;
}

} // namespace

std::string in_words(const WorldScene& scene) {
  std::string laws = scene.is_open                           ? ""
                     : scene.contact == ContactLaw::surfaces ? "; contact by surfaces"
                                                             : "; contact by cells";
  if (scene.friction > 0)
    laws += fmt::format(", friction {:g}", scene.friction);
  if (const auto& dynamics = scene.dynamics)
    laws += fmt::format("; dynamics with gravity ({:g}, {:g}, {:g}) m/s^2, restitution {:g}, damping {:g} /s",
                        dynamics->gravity[0], dynamics->gravity[1], dynamics->gravity[2],
                        dynamics->restitution, dynamics->damping);
  return fmt::format("{}D world of {} cells, {} fixed, {} rigid, {} deformable object{}{}", scene.dimension,
                     cells_in_words(scene), count(scene, ObjectKind::fixed), count(scene, ObjectKind::rigid),
                     count(scene, ObjectKind::deformable), scene.objects.size() == 1 ? "" : "s", laws);
}

} // namespace maille::studies
