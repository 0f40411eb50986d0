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
# Hardening, since scenes and images come from strangers: stack protector, checked libc calls, control-flow enforcement, read-only relocations.
# Sanitizers have checks of their own, which _FORTIFY_SOURCE would hide.
if(NOT (MAILLE_SANITIZE OR MAILLE_SANITIZE_THREADS OR MAILLE_FUZZ))
  target_compile_options(maille_compile_options INTERFACE -fstack-protector-strong
    $<$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},x86_64>:-fcf-protection> $<$<NOT:$<CONFIG:Debug>>:-D_FORTIFY_SOURCE=2>)
  target_link_options(maille_compile_options INTERFACE LINKER:-z,relro,-z,now)
endif()
set(address_and_undefined -fsanitize=address,undefined)
if(MAILLE_SANITIZE)
  # Undefined behaviour is looked for in the product: tests, most of what is compiled, take thrice the time with it. Checks of every
  # pointer, which the address sanitizer's do for, take a fifth of the time, and those for overflow half of that of a kernel
  # (scan_kernel.cpp); the fuzzers have them.
  set(is_test $<BOOL:$<TARGET_PROPERTY:MAILLE_IS_TEST>>)
  target_compile_options(maille_compile_options INTERFACE -fsanitize=address -fno-sanitize-recover=undefined -fno-omit-frame-pointer
    "$<$<NOT:${is_test}>:-fsanitize=undefined;-fno-sanitize=null,alignment,object-size,pointer-overflow,vptr>")
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

# Highway compiles a kernel once for each kind of processor, which takes most of a sanitized build. Processors without
# AVX2 run SSSE3's; sanitized builds have the plain version and AVX2.
set(disabled_targets)
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  set(disabled_targets "HWY_DISABLED_TARGETS=(HWY_SSE4)")
  if(MAILLE_SANITIZE OR MAILLE_SANITIZE_THREADS OR MAILLE_FUZZ)
    set(disabled_targets "HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3)")
  endif()
endif()

# Links a test against deal.II and VTK in a second or two, for which GNU ld takes twenty.
find_program(LLD_PROGRAM ld.lld)
if(LLD_PROGRAM)
  target_link_options(maille_compile_options INTERFACE -fuse-ld=lld)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # ccache keeps what is compiled with precompiled headers only where it is told not to mind their times.
  # Paths below the checkout count as relative ones, so that a second checkout finds what the first has compiled.
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}
      CCACHE_NOHASHDIR=1 ${CCACHE_PROGRAM})
endif()

# The same for all that share precompiled headers.
target_compile_definitions(maille_compile_options INTERFACE TOML_HEADER_ONLY=0 TOML_SHARED_LIB=1)

# Of what plugins (cmake/plugins.cmake) are linked from; functions are inlined all the same, as in programs.
add_library(maille_position_independent INTERFACE)
target_compile_options(maille_position_independent INTERFACE -fPIC $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)

# Precompiled headers halve the time of compiling. One program of each kind makes them, all others of it share them.
option(MAILLE_PRECOMPILE "Precompile headers that most files include" ON)
# What ccache asks for.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  set(precompiled_options -fpch-preprocess)
else()
  set(precompiled_options "SHELL:-Xclang -fno-pch-timestamp")
endif()
if(MAILLE_PRECOMPILE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  if(MAILLE_SANITIZE)
    # g++ 12 forgets scopes that it has precompiled, and then finds that they are left too early. What is used after its scope is
    # looked for with -DMAILLE_PRECOMPILE=OFF, which takes twice the time to compile, and by the fuzzers.
    target_compile_options(maille_compile_options INTERFACE -fno-sanitize-address-use-after-scope)
  endif()
  # What is precompiled is no system header to g++ 12 any more, which warns wrongly about strings there (GCC bug 105651).
  target_compile_options(maille_compile_options INTERFACE -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
endif()
# maille_precompiled(KIND LINK...): the object library that makes the headers in precompiled/KIND.hpp.
function(maille_precompiled kind)
  if(MAILLE_PRECOMPILE)
    file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/precompiled_${kind}.cpp CONTENT "")
    add_library(maille_precompiled_${kind} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/precompiled_${kind}.cpp)
    set_target_properties(maille_precompiled_${kind} PROPERTIES MAILLE_IS_TEST $<STREQUAL:${kind},tests>)
    target_link_libraries(maille_precompiled_${kind} PRIVATE maille_compile_options ${ARGN})
    target_compile_features(maille_precompiled_${kind} PRIVATE cxx_std_20)
    target_compile_options(maille_precompiled_${kind} PRIVATE ${precompiled_options})
    target_precompile_headers(maille_precompiled_${kind} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled/${kind}.hpp)
  endif()
endfunction()
function(maille_use_precompiled target kind)
  if(TARGET maille_precompiled_${kind})
    target_compile_options(${target} PRIVATE ${precompiled_options})
    target_precompile_headers(${target} REUSE_FROM maille_precompiled_${kind})
  endif()
endfunction()

# maille_module(NAME [POSITION_INDEPENDENT] [PRECOMPILED KIND] SOURCES ... HEADERS ... [LINK ...] [LINK_PRIVATE ...])
# POSITION_INDEPENDENT: shared objects are linked from it too.
function(maille_module name)
  cmake_parse_arguments(arg "POSITION_INDEPENDENT" "PRECOMPILED" "SOURCES;HEADERS;LINK;LINK_PRIVATE" ${ARGN})
  add_library(maille_${name} STATIC ${arg_SOURCES})
  add_library(maille::${name} ALIAS maille_${name})
  set_target_properties(maille_${name} PROPERTIES EXPORT_NAME ${name})
  target_sources(maille_${name} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${arg_HEADERS})
  target_compile_features(maille_${name} PUBLIC cxx_std_20)
  target_link_libraries(maille_${name} PUBLIC ${arg_LINK}
    PRIVATE ${arg_LINK_PRIVATE} $<BUILD_INTERFACE:maille_compile_options>)
  # The target maille_NAME_verify_interface_header_sets compiles every public header alone.
  set_target_properties(maille_${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
  set(precompiled library)
  if(arg_POSITION_INDEPENDENT)
    target_link_libraries(maille_${name} PRIVATE $<BUILD_INTERFACE:maille_position_independent>)
    set(precompiled position_independent)
  endif()
  if(arg_PRECOMPILED)
    set(precompiled ${arg_PRECOMPILED})
  endif()
  maille_use_precompiled(maille_${name} ${precompiled})
  # Kernels are compiled once for every kind of processor, each with its own flags.
  set(kernels ${arg_SOURCES})
  list(FILTER kernels INCLUDE REGEX "kernel[.]cpp$")
  set_source_files_properties(${kernels} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
  # A few more are so, and named by what they compute.
  set(for_every_target ${arg_SOURCES})
  list(FILTER for_every_target INCLUDE REGEX "(kernel|componentwise_double|slot_interpolation|wavefront_block|brick_rows)[.]cpp$")
  set_source_files_properties(${for_every_target} PROPERTIES COMPILE_DEFINITIONS "${disabled_targets}")
endfunction()
