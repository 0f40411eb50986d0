/// What libFuzzer calls for every input: one of the functions of readers.cpp, compiled once for each.

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace maille::fuzzing {

/// @return 0, as libFuzzer wants it
int MAILLE_READER(std::string_view text);

} // namespace maille::fuzzing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return maille::fuzzing::MAILLE_READER({reinterpret_cast<const char*>(data), size});
}

/// VTK's JPEG reader leaks its name's buffer where libjpeg jumps out of a faulty image.
extern "C" const char* __lsan_default_suppressions();

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvtkIOImage";
}
