#pragma once
/// Reading a piece of TOML and telling its faults as the lines that people see.

#include "maille/materials/toml_reader.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace maille::test {

/// The faults that `read(TableReader&)` finds in `text`, unknown keys among them, one message each.
template<typename Read>
std::vector<std::string> faults_of(std::string_view text, Read read) {
  std::vector<std::string> messages;
  try {
    const toml::table document = parse_toml(text, "scene.toml");
    FaultList faults("scene.toml");
    TableReader table(document, "", faults);
    read(table);
    table.finish();
    faults.throw_if_any();
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults()) {
      messages.push_back(to_string(fault));
    }
  }
  return messages;
}

} // namespace maille::test
