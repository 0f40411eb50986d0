/// VTK's image data.

#include "fuzz_image.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace maille::fuzzing;
  static const ScratchFile file("a.vti");
  return read_one_image(file.holding(text_of(data, size)));
}
