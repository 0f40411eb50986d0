# Flags that every target of ours takes. Linked with BUILD_INTERFACE, so users of the installed
# package get none of them.
add_library(maille_compile_options INTERFACE)
target_compile_options(maille_compile_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow
  # clang, which is here for the fuzzers, warns of other conversions.
  $<$<CXX_COMPILER_ID:GNU>:-Wconversion>
  $<$<CXX_COMPILER_ID:GNU>:-Werror>
  # g++ 12 warns wrongly about string concatenation (GCC bug 105329).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # Fused multiply-add depends on the machine; the same input must give the same bits.
  -ffp-contract=off)
set(address_and_undefined -fsanitize=address,undefined)
if(MAILLE_SANITIZE)
  # Undefined behaviour, and what is used after its scope, are looked for in the product: tests, most of what is compiled, take thrice
  # the time with them.
  target_compile_options(maille_compile_options INTERFACE -fsanitize=address
    $<IF:$<BOOL:$<TARGET_PROPERTY:MAILLE_IS_TEST>>,-fno-sanitize-address-use-after-scope,-fsanitize=undefined>
    -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(maille_compile_options INTERFACE ${address_and_undefined})
endif()
if(MAILLE_SANITIZE_THREADS)
  target_compile_options(maille_compile_options INTERFACE -fsanitize=thread -fno-omit-frame-pointer)
  target_link_options(maille_compile_options INTERFACE -fsanitize=thread)
endif()
if(MAILLE_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "libFuzzer comes with clang: cmake --preset fuzz")
  endif()
  target_compile_options(maille_compile_options INTERFACE ${address_and_undefined} -fsanitize=float-cast-overflow,fuzzer-no-link
    -fno-sanitize-recover=undefined,float-cast-overflow -fno-omit-frame-pointer)
  target_link_options(maille_compile_options INTERFACE ${address_and_undefined} -fsanitize=float-cast-overflow)
endif()

if(MAILLE_SANITIZE OR MAILLE_SANITIZE_THREADS OR MAILLE_FUZZ)
  # Kernels are compiled for every kind of processor, which takes most of a sanitized build: the two widest and none at all will do.
  target_compile_definitions(maille_compile_options INTERFACE "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4)")
endif()

# Links a test against deal.II and VTK in a second or two, for which GNU ld takes twenty.
find_program(LLD_PROGRAM ld.lld)
if(LLD_PROGRAM)
  target_link_options(maille_compile_options INTERFACE -fuse-ld=lld)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# maille_module(NAME SOURCES ... HEADERS ... [LINK ...] [LINK_PRIVATE ...])
function(maille_module name)
  cmake_parse_arguments(arg "" "" "SOURCES;HEADERS;LINK;LINK_PRIVATE" ${ARGN})
  add_library(maille_${name} STATIC ${arg_SOURCES})
  add_library(maille::${name} ALIAS maille_${name})
  set_target_properties(maille_${name} PROPERTIES EXPORT_NAME ${name})
  target_sources(maille_${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
  target_compile_features(maille_${name} PUBLIC cxx_std_20)
  target_link_libraries(maille_${name} PUBLIC ${arg_LINK}
    PRIVATE ${arg_LINK_PRIVATE} $<BUILD_INTERFACE:maille_compile_options>)
endfunction()
