# How every folder becomes a target, and with which flags.
include(GNUInstallDirs)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

find_program(SEXTANT_CCACHE ccache)
if(SEXTANT_CCACHE AND PROJECT_IS_TOP_LEVEL)
  # Objects of another checkout count, and so do those made with a precompiled header.
  set(launcher ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${SEXTANT_CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${launcher})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${launcher})
endif()

# Flags of our own code; generated code and other people's headers do not get them.
add_library(sextant_flags INTERFACE)
target_compile_options(sextant_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion -Wnon-virtual-dtor
  -Woverloaded-virtual -Wold-style-cast -Wcast-qual -Wformat=2 -Wundef
  $<$<BOOL:${SEXTANT_WARNINGS_AS_ERRORS}>:-Werror>
  # GCC 12 sees overlapping copies in std::string's operator+ where there are none (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # The compiler collects its garbage from 1 GB on, not from 128 MB: a tenth of the time of a file with templates.
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1048576>
  # std::sqrt as one instruction: nobody reads errno. No other liberty with floating point is taken.
  -fno-math-errno
  # Pairs of scalars that are loaded as one vector wait for their stores: a control step takes half as long again.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:-fno-tree-slp-vectorize>)
# Eigen forms such pairs itself, where it copies a state: the plant's integration over a modulated pattern then takes
# 1.7 times as long. The alignment stays that of a program which has them, so that both can be linked.
target_compile_definitions(sextant_flags INTERFACE
  $<$<CONFIG:Release>:EIGEN_DONT_VECTORIZE>
  $<$<CONFIG:Release>:EIGEN_MAX_STATIC_ALIGN_BYTES=16>)

# Installed libraries must also be of use to a linker that does not optimise across files.
if(CMAKE_INTERPROCEDURAL_OPTIMIZATION)
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-ffat-lto-objects>)
endif()
if(SEXTANT_ASSERTIONS)
  foreach(type RELWITHDEBINFO RELEASE)
    string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_${type} "${CMAKE_CXX_FLAGS_${type}}")
  endforeach()
  add_compile_definitions($<$<COMPILE_LANGUAGE:CXX>:_GLIBCXX_ASSERTIONS>)
endif()
if(SEXTANT_SANITIZE)
  add_compile_options(-fsanitize=${SEXTANT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${SEXTANT_SANITIZE})
endif()
if(SEXTANT_COVERAGE)
  add_compile_options(--coverage -fprofile-update=atomic)
  add_link_options(--coverage)
endif()

# sextant_add_library(<folder> [SOURCES files...] [PUBLIC targets...] [PRIVATE targets...])
# The target sextant_<folder> (alias sextant::<folder>), exported as sextant::<folder>. Without sources it is
# header-only. PUBLIC and PRIVATE are link dependencies.
function(sextant_add_library folder)
  cmake_parse_arguments(arg "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target sextant_${folder})
  if(arg_SOURCES)
    add_library(${target} STATIC ${arg_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:sextant_flags>)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(sextant::${folder} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${folder})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(${target} ${scope} ${arg_PUBLIC})
  if(arg_PRIVATE)
    target_link_libraries(${target} PRIVATE ${arg_PRIVATE})
  endif()
  install(TARGETS ${target} EXPORT SextantTargets)
endfunction()

# sextant_add_tests(<folder> SOURCES files... [LIBRARIES targets...])
# One GoogleTest program a folder; each TEST becomes a ctest named <folder>.<suite>.<case>.
function(sextant_add_tests folder)
  cmake_parse_arguments(arg "" "" "SOURCES;LIBRARIES" ${ARGN})
  set(target sextant_${folder}_tests)
  add_executable(${target} ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE sextant_flags sextant::${folder} ${arg_LIBRARIES} GTest::gmock_main)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  sextant_use_source_directory(${target})
  sextant_precompile_test_headers(${target})
  gtest_discover_tests(${target} TEST_PREFIX ${folder}. DISCOVERY_TIMEOUT 480 PROPERTIES TIMEOUT 480)
endfunction()

# sextant_use_source_directory(<target>): support/source_directory.hpp, which defines SEXTANT_SOURCE_DIR. Only the
# sources that include it are compiled again in another checkout.
function(sextant_use_source_directory target)
  set(generated ${PROJECT_BINARY_DIR}/tests/generated)
  file(CONFIGURE OUTPUT ${generated}/support/source_directory.hpp @ONLY
    CONTENT "#pragma once\n#define SEXTANT_SOURCE_DIR \"@PROJECT_SOURCE_DIR@\"\n")
  target_include_directories(${target} PRIVATE ${generated})
endfunction()

# sextant_precompile_test_headers(<target>): the headers that tests/CMakeLists.txt names, compiled once for all tests.
function(sextant_precompile_test_headers target)
  target_precompile_headers(${target} REUSE_FROM sextant_precompiled_tests)
  target_link_libraries(${target} PRIVATE Eigen3::Eigen)
  # Without -fpch-preprocess ccache does not see a precompiled header. GCC 12 sees copies beyond a string in its
  # operator+ where there are none (GCC bug 105651).
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess -Wno-array-bounds -Wno-stringop-overflow>)
endfunction()

# sextant_add_program(<name> SOURCES files... [LIBRARIES targets...])
function(sextant_add_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE sextant_flags ${arg_LIBRARIES})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()
