# The engines the benchmark runs beside ours. Each is optional: one that is absent is reported as skipped.
file(GLOB _peers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/benchmark/peers/*.cpp)
add_library(simulation_peers STATIC ${_peers})
target_link_libraries(simulation_peers PUBLIC ${PROJECT_NAME} PRIVATE omniflight_warnings)

find_package(PkgConfig)
if(PkgConfig_FOUND)
  pkg_check_modules(ODE IMPORTED_TARGET ode)
  pkg_check_modules(BULLET IMPORTED_TARGET bullet)
endif()
# not by its CMake package: Debian's asks for headers of a package that libmujoco-dev does not bring
find_path(OMNIFLIGHT_MUJOCO_HEADERS mujoco/mujoco.h)
find_library(OMNIFLIGHT_MUJOCO_LIBRARY mujoco)
if(TARGET PkgConfig::ODE)
  target_link_libraries(simulation_peers PRIVATE PkgConfig::ODE)
  target_compile_definitions(simulation_peers PRIVATE OMNIFLIGHT_HAVE_ODE)
endif()
if(TARGET PkgConfig::BULLET)
  target_link_libraries(simulation_peers PRIVATE PkgConfig::BULLET)
  target_compile_definitions(simulation_peers PRIVATE OMNIFLIGHT_HAVE_BULLET)
endif()
if(OMNIFLIGHT_MUJOCO_HEADERS AND OMNIFLIGHT_MUJOCO_LIBRARY)
  target_include_directories(simulation_peers SYSTEM PRIVATE ${OMNIFLIGHT_MUJOCO_HEADERS})
  target_link_libraries(simulation_peers PRIVATE ${OMNIFLIGHT_MUJOCO_LIBRARY})
  target_compile_definitions(simulation_peers PRIVATE OMNIFLIGHT_HAVE_MUJOCO)
endif()

# The batch under other names, with a kernel tuned for this processor, fused multiply-add allowed: what the
# portable one is measured against. Alignment stays that of the portable headers.
set(_simulation ${CMAKE_CURRENT_SOURCE_DIR}/src)
add_library(simulation_native_kernel OBJECT ${_simulation}/lane_kernel_avx2.cpp ${_simulation}/lane_kernel_avx3.cpp
            ${_simulation}/lane_dispatch.cpp)
target_compile_definitions(simulation_native_kernel PRIVATE HWY_COMPILE_ONLY_STATIC OMNIFLIGHT_LANES_FMA)
target_compile_options(simulation_native_kernel PRIVATE -O3 -march=native -Wno-maybe-uninitialized)
add_library(simulation_native STATIC ${CMAKE_CURRENT_SOURCE_DIR}/benchmark/native.cpp ${_simulation}/batch.cpp
            ${_simulation}/lanes.cpp $<TARGET_OBJECTS:simulation_native_kernel>)
foreach(_target simulation_native_kernel simulation_native)
  target_compile_definitions(${_target} PRIVATE Batch=NativeBatch BatchConfig=NativeBatchConfig
    flies_in_lanes=native_flies_in_lanes lane_effects=native_lane_effects
    lane_instruction_set=native_lane_instruction_set lanes=native_lanes EIGEN_MAX_ALIGN_BYTES=16)
  target_include_directories(${_target} PRIVATE ${_simulation})
  target_link_libraries(${_target} PUBLIC ${PROJECT_NAME} hwy::hwy PRIVATE omniflight_warnings)
endforeach()
target_link_libraries(simulation_peers PUBLIC simulation_native)
