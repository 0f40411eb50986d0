/// Files of the tissue library.

#include "fuzzing.hpp"
#include "maille/materials/library.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace maille;
  return fuzzing::tried([&] {
    const LibraryEntry entry = parse_library_entry(fuzzing::text_of(data, size), "tissue.toml", "a/tissue");
    fuzzing::require(violated_inequalities(entry.material.elasticity).empty(), "positive strain energy");
  });
}
