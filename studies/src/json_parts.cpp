#include "json_parts.hpp"

#include "maille/materials/text_file.hpp"
#include "maille/studies/version.hpp"
#include "text.hpp"

#include <fmt/chrono.h>

#include <chrono>

namespace maille::studies {

nlohmann::ordered_json question_json(const Scene& scene, int threads) {
  return {{"scene", scene.name},
          {"title", scene.title},
          {"maille", version},
          {"commit", commit()},
          {"dimension", scene.dimension()},
          {"cells", scene.specimen.n_matter_cells()},
          {"nodes", scene.specimen.n_matter_nodes()},
          {"threads", threads}};
}

nlohmann::ordered_json norms_json(const ErrorNorms& error) {
  return {{"relative_l2", json_number(error.relative_l2)},
          {"relative_max", json_number(error.relative_max)},
          {"rms", json_number(error.rms)}};
}

nlohmann::ordered_json made_by() {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  return {{"maille", version},
          {"commit", commit()},
          {"host", name_of_machine()},
          {"date", fmt::format("{:%Y-%m-%d %H:%M UTC}", now)}};
}

std::string provenance_with(const nlohmann::ordered_json& facts) {
  nlohmann::ordered_json all{{"maille", version}, {"commit", commit()}};
  all.update(facts);
  return all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

} // namespace maille::studies
