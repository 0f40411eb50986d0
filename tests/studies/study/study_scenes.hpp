#pragma once
/// Small studies that tests run.

#include "support/temporary_folder.hpp"

#include <string>

namespace maille::test {

/// A strip that finite elements answer in milliseconds.
inline const std::string small_strip = R"(title = "a strip"
[specimen]
shape    = "box"
cells    = [8, 4]
spacing  = "1 mm"
material = { E_fibre = "20 kPa", E_cross = "10 kPa", G_fibre = "4 kPa", nu_fibre = 0.3, nu_cross = 0.3 }
fibre    = { angle = "0 deg", plane = "xy" }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by    = ["0.4 mm", 0]
)";

/// The head of a study of `strip.toml`; parameters follow.
inline const std::string small_head = R"(scene = "strip.toml"
methods = ["limits", "relaxed"]
reference = "fem_q1"
)";

/// One parameter as a table.
inline std::string parameter(const std::string& key, const std::string& values) {
  return "[[parameter]]\nkey = \"" + key + "\"\n" + values + "\n";
}

/// A folder with the strip in it.
struct StudyFolder : TemporaryFolder {
  StudyFolder() { write("strip.toml", small_strip); }
};

} // namespace maille::test
