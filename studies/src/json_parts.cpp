#include "json_parts.hpp"

#include "maille/studies/version.hpp"
#include "text.hpp"

namespace maille::studies {

nlohmann::ordered_json question_json(const Scene& scene, int threads) {
  return {{"scene", scene.name},
          {"title", scene.title},
          {"maille", version},
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

nlohmann::ordered_json in_json(const Plausibility& found) {
  nlohmann::ordered_json out{{"size_m", found.size},
                             {"largest_move_m", found.largest_move},
                             {"move_over_length", found.move_over_length},
                             {"mean_strain", nullptr},
                             {"strain_of_loads", nullptr},
                             {"warnings", found.warnings}};
  if (found.mean_strain)
    out["mean_strain"] = json_number(*found.mean_strain);
  if (found.strain_of_loads)
    out["strain_of_loads"] = json_number(*found.strain_of_loads);
  return out;
}

nlohmann::ordered_json seconds_json(const Seconds& seconds) {
  return {{"setup", seconds.setup}, {"solve", seconds.solve}, {"total", seconds.total()}};
}

nlohmann::ordered_json faults_json(const std::vector<Fault>& faults) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Fault& fault : faults)
    list.push_back({{"file", fault.file},
                    {"line", fault.line},
                    {"key", fault.key},
                    {"expected", fault.expected},
                    {"found", fault.found}});
  return list;
}

} // namespace maille::studies
