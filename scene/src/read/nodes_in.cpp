#include "maille/scene/nodes_in.hpp"

#include "read/reader.hpp"

#include <cstdint>
#include <string>

namespace maille {

std::vector<std::int64_t> nodes_in(const Scene& scene, std::string_view where) {
  FaultList faults("");
  faults.units = {1.0, 1.0};
  const std::string text(where);
  const toml::table document =
      parse_toml("where = " + (text.starts_with('{') ? text : "\"" + text + "\""), "");
  TableReader table(document, "", faults);
  const auto region = reader::read_region(table, scene.dimension(), &scene.specimen);
  faults.throw_if_any();
  return region ? region->nodes(scene.specimen) : std::vector<std::int64_t>{};
}

} // namespace maille
