# What the CAN codec is made of: msgpack, and the code generated from the contract in configs/interfaces.
find_package(msgpack 4 CONFIG REQUIRED)

# The Python that has cantools; -DSEXTANT_PYTHON names another. Looked for anew in each run of CMake, because
# scripts/setup may have made .venv since the last.
if(NOT SEXTANT_PYTHON)
  set(SEXTANT_PYTHON python3)
  if(EXISTS ${PROJECT_SOURCE_DIR}/.venv/bin/python)
    set(SEXTANT_PYTHON ${PROJECT_SOURCE_DIR}/.venv/bin/python)
  endif()
endif()
execute_process(COMMAND ${SEXTANT_PYTHON} -c "import cantools" RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
if(failed)
  message(FATAL_ERROR "${SEXTANT_PYTHON} has no cantools, which generates the CAN code: run scripts/setup")
endif()

# sextant_add_generated_library(<name> SOURCES files... INCLUDE dir [PUBLIC targets...])
# C that a generator wrote: exported like our own, free of our warnings, its headers seen as system headers.
function(sextant_add_generated_library name)
  cmake_parse_arguments(arg "" "INCLUDE" "SOURCES;PUBLIC" ${ARGN})
  set(target sextant_${name})
  add_library(${target} STATIC ${arg_SOURCES})
  add_library(sextant::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} SYSTEM PUBLIC $<BUILD_INTERFACE:${arg_INCLUDE}>)
  target_link_libraries(${target} PUBLIC ${arg_PUBLIC})
  install(TARGETS ${target} EXPORT SextantTargets)
endfunction()
