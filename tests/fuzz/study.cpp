/// Studies, over the scenes among the fixtures, and the scenes of their first cases.

#include "maille/studies/study.hpp"
#include "fuzzing.hpp"
#include "maille/scene/read_scene.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maille::set_file_scope(maille::FileScope::sandbox); // what is tried reads nothing but fixtures
  using namespace maille;
  return fuzzing::tried([&] {
    const auto study = studies::parse_study(fuzzing::text_of(data, size), fuzzing::fixtures() / "study.toml");
    fuzzing::require(!study.scenes.empty() && !study.methods.empty(), "scenes and methods");
    fuzzing::require(studies::n_cases(study) <= 1'000'000, "no more cases than is said");
    if (studies::n_cases(study) > 1000)
      return; // all alike
    const auto cases = studies::cases(study);
    fuzzing::require(static_cast<std::int64_t>(cases.size()) == studies::n_cases(study),
                     "as many cases as are counted");
    for (std::size_t i = 0; i < cases.size() && i < 3; ++i)
      fuzzing::require(!studies::resolved_scene(study, cases[i]).empty(), "a scene for every case");
  });
}
