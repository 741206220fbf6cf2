# The list of faults is the CAN contract: the value table of MCU_Faults.FirstFault and the comments of the signals
# of MCU_FaultsActive. From it come sextant/core/fault_list.hpp and a table for people. CMake alone makes them, so
# that the core needs no Python. Without a project:
#   cmake -DDBC=configs/interfaces/sextant.dbc -DOUTPUT=build -P cmake/SextantFaults.cmake

# sextant_generate_faults(<dbc> <output>): <output>/include/sextant/core/fault_list.hpp and <output>/docs/faults.md.
function(sextant_generate_faults dbc output)
  set(here ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  if(NOT CMAKE_SCRIPT_MODE_FILE)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${dbc})
  endif()
  file(READ ${dbc} contract)
  sextant_message_id(MCU_Faults faults)
  sextant_message_id(MCU_FaultsActive active)
  if(NOT contract MATCHES "VAL_ ${faults} FirstFault ([^;]*);")
    message(FATAL_ERROR "${dbc} has no value table for MCU_Faults.FirstFault, the list of faults")
  endif()
  string(REGEX MATCHALL "[0-9]+ \"[A-Z0-9_]+\"" entries "${CMAKE_MATCH_1}")

  set(count 0)
  foreach(entry IN LISTS entries)
    string(REGEX MATCH "([0-9]+) \"([A-Z0-9_]+)\"" entry "${entry}")
    set(value ${CMAKE_MATCH_1})
    set(name ${CMAKE_MATCH_2})
    if(name STREQUAL "NONE")
      continue()
    endif()
    if(NOT value EQUAL count)
      message(FATAL_ERROR "${dbc}: fault ${name} of FirstFault has the value ${value}, not the next one, ${count}")
    endif()
    sextant_camel_case(${name} signal)
    if(NOT contract MATCHES "CM_ SG_ ${active} Active${signal} \"([^\"]+)\"")
      message(FATAL_ERROR "${dbc}: fault ${name} has no comment: CM_ SG_ ${active} Active${signal}")
    endif()
    set(text "${CMAKE_MATCH_1}")
    string(TOLOWER ${name} enumerator)
    string(APPEND enumerators "  ${enumerator} = ${value},  ///< ${text}\n")
    string(APPEND names "    \"${name}\",\n")
    string(APPEND rows "| ${value} | ${name} | ${text} |\n")
    math(EXPR count "${count} + 1")
  endforeach()

  configure_file(${here}/fault_list.hpp.in ${output}/include/sextant/core/fault_list.hpp @ONLY)
  configure_file(${here}/faults.md.in ${output}/docs/faults.md @ONLY)
endfunction()

# The identifier of a message of `contract`, the caller's.
function(sextant_message_id name result)
  if(NOT contract MATCHES "BO_ ([0-9]+) ${name}:")
    message(FATAL_ERROR "the CAN contract has no message ${name}, which belongs to the list of faults")
  endif()
  set(${result} ${CMAKE_MATCH_1} PARENT_SCOPE)
endfunction()

# OVER_SPEED is OverSpeed.
function(sextant_camel_case name result)
  string(REPLACE "_" ";" words ${name})
  foreach(word IN LISTS words)
    string(SUBSTRING ${word} 0 1 first)
    string(SUBSTRING ${word} 1 -1 rest)
    string(TOLOWER "${rest}" rest)
    string(APPEND camel ${first}${rest})
  endforeach()
  set(${result} ${camel} PARENT_SCOPE)
endfunction()

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  sextant_generate_faults(${DBC} ${OUTPUT})
endif()
