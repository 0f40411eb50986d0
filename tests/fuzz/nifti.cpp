/// NIfTI, packed (.nii.gz) where the input is a gzip file and plain otherwise.

#include "fuzz_image.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace maille::fuzzing;
  static const ScratchFile plain("a.nii"), packed("a.nii.gz");
  const std::string_view bytes = text_of(data, size);
  return read_one_image((bytes.starts_with("\x1f\x8b") ? packed : plain).holding(bytes));
}
