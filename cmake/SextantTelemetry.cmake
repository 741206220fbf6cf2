# The list of telemetry signals is the DDS contract, configs/interfaces/telemetry.idl: names, types, units and texts.
# From it come the records sextant/core/telemetry_record.hpp and sextant/comms/real_time_sample.hpp, with lists of their
# members, and a table for people. CMake alone makes them, so that the core needs neither Python nor idlc. Without a
# project:
#   cmake -DIDL=configs/interfaces/telemetry.idl -DOUTPUT=build -P cmake/SextantTelemetry.cmake
if(CMAKE_SCRIPT_MODE_FILE)
  cmake_minimum_required(VERSION 3.25)
endif()

# sextant_generate_telemetry(<idl> <output>): <output>/include/sextant/core/telemetry_record.hpp,
# <output>/include/sextant/comms/real_time_sample.hpp and <output>/docs/telemetry.md.
function(sextant_generate_telemetry idl output)
  set(here ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  if(NOT CMAKE_SCRIPT_MODE_FILE)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${idl})
  endif()
  file(READ ${idl} contract)
  sextant_telemetry_enumerators(DriveStateKind DriveState)
  sextant_telemetry_enumerators(WaitKind WaitMode)
  sextant_telemetry_enumerators(SchedulingKind SchedulingPolicy)
  # The word for a statistic, by the part of a member's name that says it.
  set(sextant_statistic_mean "mean")
  set(sextant_statistic_min "minimum")
  set(sextant_statistic_max "maximum")
  set(sextant_statistic_p50 "median")
  set(sextant_statistic_p99 "99 % quantile")
  set(sextant_statistic_p99_9 "99.9 % quantile")
  set(sextant_statistic_p99_99 "99.99 % quantile")
  # What only the publisher knows is no member of a record.
  sextant_telemetry_struct(DriveTelemetry telemetry T drive_id sequence dropped)
  sextant_telemetry_struct(DriveState state float drive_id sequence)
  sextant_telemetry_struct(RealTimeStatistics statistics float drive_id sequence)

  configure_file(${here}/telemetry_record.hpp.in ${output}/include/sextant/core/telemetry_record.hpp @ONLY)
  configure_file(${here}/real_time_sample.hpp.in ${output}/include/sextant/comms/real_time_sample.hpp @ONLY)
  configure_file(${here}/telemetry.md.in ${output}/docs/telemetry.md @ONLY)
endfunction()

# sextant_telemetry_enumerators(<enum of the contract> <enum of C++>): <enum of C++>_enumerators, the lines of a list.
function(sextant_telemetry_enumerators name cpp)
  if(NOT contract MATCHES "enum ${name} {([^}]*)}")
    message(FATAL_ERROR "${idl} has no enumeration ${name}")
  endif()
  string(REGEX MATCHALL "[A-Z_]+" names "${CMAKE_MATCH_1}")
  foreach(upper IN LISTS names)
    string(TOLOWER ${upper} lower)
    string(APPEND lines " \\\n  X(${cpp}, ${lower}, ${upper})")
  endforeach()
  set(${cpp}_enumerators "${lines}" PARENT_SCOPE)
endfunction()

# sextant_telemetry_struct(<struct> <prefix> <C++ type of float> <members that are the publisher's>...):
# <prefix>_members, declarations in C++; <prefix>_list, the lines of a list; <prefix>_rows, of a table.
function(sextant_telemetry_struct struct prefix float)
  string(FIND "${contract}" "  struct ${struct} {\n" begin)
  if(begin EQUAL -1)
    message(FATAL_ERROR "${idl} has no struct ${struct}")
  endif()
  string(LENGTH "  struct ${struct} {\n" head)
  math(EXPR begin "${begin} + ${head}")
  string(SUBSTRING "${contract}" ${begin} -1 body)
  string(FIND "${body}" "\n  };" end)
  math(EXPR end "${end} + 1")
  string(SUBSTRING "${body}" 0 ${end} body)

  while(body MATCHES "^([^\n]*)\n(.*)$")
    set(line "${CMAKE_MATCH_1}")
    set(body "${CMAKE_MATCH_2}")
    if(NOT line MATCHES "^    (@key )?([A-Za-z0-9<> ]+) _?([a-z][a-z0-9_]*);(.*)$")
      message(FATAL_ERROR "${idl}: ${struct} has the line \"${line}\", which is not a member: "
        "its form is \"    type name;  // [unit] text\"")
    endif()
    set(type "${CMAKE_MATCH_2}")
    set(name ${CMAKE_MATCH_3})
    set(comment "${CMAKE_MATCH_4}")
    sextant_telemetry_text()
    sextant_telemetry_type()
    string(APPEND rows "| `${name}` | ${type} | ${unit} | ${text} |\n")
    if(NOT name IN_LIST ARGN)
      string(APPEND members "  ${cpp} ${name}{};  ///< ${text} [${unit}]\n")
      string(APPEND list " \\\n  X(${name}, \"${unit}\", \"${text}\")")
    endif()
  endwhile()
  foreach(result IN ITEMS members list rows)
    set(${prefix}_${result} "${${result}}" PARENT_SCOPE)
  endforeach()
endfunction()

# unit and text of the member `name` with `comment`, the caller's. A statistic without comment has unit and text of the
# mean or median before it (`quantity`, of the members so far), with its own word.
macro(sextant_telemetry_text)
  set(statistic "")
  set(base ${name})
  if(name MATCHES "^(.*)_(mean|min|max|p50|p99|p99_9|p99_99)_([a-z]+)$")
    set(base "${CMAKE_MATCH_1} in ${CMAKE_MATCH_3}")
    set(statistic ${CMAKE_MATCH_2})
  endif()
  if(comment MATCHES "^ *// \\[([^]]+)\\] (.+)$")
    set(unit "${CMAKE_MATCH_1}")
    set(text "${CMAKE_MATCH_2}")
    set(quantity "${base}")
    set(quantity_text "${text}")
    set(quantity_word "${sextant_statistic_${statistic}}")
  elseif(comment STREQUAL "" AND statistic AND base STREQUAL quantity AND quantity_text MATCHES "${quantity_word} over")
    string(REPLACE "${quantity_word} over" "${sextant_statistic_${statistic}} over" text "${quantity_text}")
  else()
    message(FATAL_ERROR "${idl}: ${struct}.${name} has no unit and text: its comment is \"// [unit] text\"")
  endif()
  if(text MATCHES "[\"\\|]")
    message(FATAL_ERROR "${idl}: ${struct}.${name}: the text must be without \", \\ and |")
  endif()
endmacro()

# cpp, the type in C++ of the member `name` of `type`, the caller's.
macro(sextant_telemetry_type)
  set(types
    "octet=std::uint8_t" "long=std::int32_t" "unsigned long=std::uint32_t" "long long=std::int64_t"
    "unsigned long long=std::uint64_t" "float=${float}" "double=double" "boolean=bool" "string<64>=std::string_view"
    "DriveStateKind=DriveState" "WaitKind=WaitMode" "SchedulingKind=SchedulingPolicy")
  set(cpp "")
  foreach(pair IN LISTS types)
    if(pair MATCHES "^${type}=(.*)$")
      set(cpp ${CMAKE_MATCH_1})
    endif()
  endforeach()
  if(NOT cpp)
    message(FATAL_ERROR "${idl}: ${struct}.${name} has the type \"${type}\", which the telemetry has no place for")
  endif()
endmacro()

if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  sextant_generate_telemetry(${IDL} ${OUTPUT})
endif()
