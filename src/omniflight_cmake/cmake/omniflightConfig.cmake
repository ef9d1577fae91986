# find_package(omniflight 0.2 REQUIRED COMPONENTS vehicle simulation): the libraries as targets omniflight::vehicle,
# omniflight::simulation; what they need is found with them. Without COMPONENTS: all that are installed.
#
#   cmake_minimum_required(VERSION 3.22)
#   project(mine LANGUAGES CXX)
#   find_package(omniflight 0.2 REQUIRED COMPONENTS simulation)
#   add_executable(mine mine.cpp)
#   target_link_libraries(mine PRIVATE omniflight::simulation)
#   target_compile_features(mine PRIVATE cxx_std_20)
#
# cmake -DCMAKE_PREFIX_PATH=WORKSPACE/install/omniflight_cmake, or after `source install/setup.bash` without it.

# A workspace of colcon has one prefix a package, beside this one.
get_filename_component(_omniflight_prefixes "${CMAKE_CURRENT_LIST_DIR}/../../../.." ABSOLUTE)
file(GLOB _omniflight_siblings LIST_DIRECTORIES true "${_omniflight_prefixes}/omniflight_*")
set(_omniflight_prefix_path "${CMAKE_PREFIX_PATH}")
list(APPEND CMAKE_PREFIX_PATH ${_omniflight_siblings} "${CMAKE_CURRENT_LIST_DIR}/../../..")

set(_omniflight_components ${omniflight_FIND_COMPONENTS})
if(NOT _omniflight_components)
  foreach(_component core files msgs vehicle physics allocation control planning recording identification gateway safety
          simulation diagnosis report reproduction view jobs campaign bus components)
    find_package(omniflight_${_component} QUIET)
    if(omniflight_${_component}_FOUND)
      list(APPEND _omniflight_components ${_component})
    endif()
  endforeach()
endif()
foreach(_component IN LISTS _omniflight_components)
  find_package(omniflight_${_component} QUIET)
  if(TARGET omniflight_${_component}::omniflight_${_component})
    set(omniflight_${_component}_FOUND TRUE)
    if(NOT TARGET omniflight::${_component})
      add_library(omniflight::${_component} INTERFACE IMPORTED)
      set_target_properties(omniflight::${_component} PROPERTIES
        INTERFACE_LINK_LIBRARIES omniflight_${_component}::omniflight_${_component})
    endif()
  else()
    set(omniflight_${_component}_FOUND FALSE)
    if(omniflight_FIND_REQUIRED_${_component})
      set(omniflight_FOUND FALSE)
      string(CONCAT omniflight_NOT_FOUND_MESSAGE "omniflight has no component '${_component}' here: it is misspelt, was not built, or a "
        "library that it needs is missing (launch_scripts/install_dependencies.sh --list)")
    endif()
  endif()
endforeach()
set(CMAKE_PREFIX_PATH "${_omniflight_prefix_path}")
