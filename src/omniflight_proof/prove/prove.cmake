# The concealed-effect proof. Three programs that share a file format and nothing else: the generator (with the plant),
# the campaign that runs the analysis where it cannot read the truth, and the scorer.
find_package(omniflight_recording REQUIRED)
find_package(omniflight_jobs REQUIRED)
find_package(omniflight_control REQUIRED)
find_package(omniflight_allocation REQUIRED)
find_package(omniflight_report REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(fmt REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Threads REQUIRED)
set(PROVE ${CMAKE_CURRENT_LIST_DIR})

add_library(omniflight_proof_protocol STATIC
  ${PROVE}/case_truth.cpp ${PROVE}/case_aliases.cpp ${PROVE}/seal.cpp ${PROVE}/prove_sandbox.cpp
  ${PROVE}/score.cpp ${PROVE}/score_answer.cpp ${PROVE}/score_leak.cpp ${PROVE}/score_stats.cpp ${PROVE}/score_table.cpp)
target_include_directories(omniflight_proof_protocol PUBLIC ${PROVE})
target_link_libraries(omniflight_proof_protocol PUBLIC omniflight_core::omniflight_core omniflight_files::omniflight_files
  nlohmann_json::nlohmann_json fmt::fmt PRIVATE ZLIB::ZLIB omniflight_warnings)

add_library(omniflight_proof_paths STATIC ${PROVE}/case_path.cpp ${PROVE}/case_shape.cpp)
target_include_directories(omniflight_proof_paths PUBLIC ${PROVE})
target_link_libraries(omniflight_proof_paths PUBLIC omniflight_core::omniflight_core PRIVATE omniflight_warnings)

add_library(omniflight_proof_cases STATIC
  ${PROVE}/case_next.cpp ${PROVE}/case_log.cpp ${PROVE}/case_flight.cpp ${PROVE}/case_mechanism.cpp ${PROVE}/case_mechanism_outside.cpp
  ${PROVE}/case_unknown.cpp ${PROVE}/case_draw.cpp ${PROVE}/case_make.cpp)
target_link_libraries(omniflight_proof_cases PUBLIC omniflight_proof omniflight_proof_protocol omniflight_proof_paths
  omniflight_control::omniflight_control omniflight_allocation::omniflight_allocation
  omniflight_recording::omniflight_recording PRIVATE Threads::Threads omniflight_warnings)
omniflight_executable(omniflight_proof_generate ${PROVE}/prove_generate.cpp
  LINK omniflight_proof_cases CLI11::CLI11)
omniflight_executable(omniflight_proof_campaign ${PROVE}/prove_campaign.cpp ${PROVE}/prove_analyse.cpp
  LINK omniflight_proof_protocol omniflight_jobs::omniflight_jobs CLI11::CLI11)
omniflight_executable(omniflight_proof_score ${PROVE}/prove_score.cpp ${PROVE}/prove_result.cpp
  LINK omniflight_proof_protocol omniflight_report::omniflight_report CLI11::CLI11)
add_library(omniflight_proof_baseline_methods STATIC ${PROVE}/baseline_data.cpp ${PROVE}/baseline_methods.cpp)
target_include_directories(omniflight_proof_baseline_methods PUBLIC ${PROVE})
target_link_libraries(omniflight_proof_baseline_methods PUBLIC omniflight_vehicle::omniflight_vehicle
  omniflight_recording::omniflight_recording fmt::fmt PRIVATE omniflight_warnings)
omniflight_executable(omniflight_proof_baselines ${PROVE}/baseline_run.cpp
  LINK omniflight_proof_baseline_methods omniflight_proof_protocol CLI11::CLI11)
foreach(_library protocol paths cases baseline_methods)
  omniflight_join(omniflight_proof_${_library})
  omniflight_precompile(omniflight_proof_${_library} REUSE_FROM omniflight_proof)
endforeach()

if(BUILD_TESTING)
  find_package(GTest REQUIRED)
  include(GoogleTest)
  function(omniflight_prove_test name)
    add_executable(${name} ${PROVE}/test/${name}.cpp)
    target_link_libraries(${name} PRIVATE ${ARGN} GTest::gtest GTest::gtest_main omniflight_warnings)
    target_compile_definitions(${name} PRIVATE OMNIFLIGHT_SOURCE_ROOT="${PROVE}/../../.."
      PROVE_CAMPAIGN="$<TARGET_FILE:omniflight_proof_campaign>" PROVE_GENERATE="$<TARGET_FILE:omniflight_proof_generate>")
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT 120)
  endfunction()
  omniflight_prove_test(test_prove_protocol omniflight_proof_protocol)
  omniflight_prove_test(test_prove_cases omniflight_proof_cases)
  omniflight_prove_test(test_prove_baselines omniflight_proof_baseline_methods)
endif()
if(BUILD_TESTING)
  # From end to end, with the analysis of the workspace when that is installed.
  find_program(OMNIFLIGHT_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
  set(analysis ${CMAKE_INSTALL_PREFIX}/../omniflight_cli/bin/omniflight)
  set(subset ${OMNIFLIGHT_PYTHON} -B ${PROVE}/test/campaign_subset.py ${CMAKE_CURRENT_BINARY_DIR} ${analysis} ${PROVE}/../../../configs)
  add_test(NAME prove.subset COMMAND ${subset})
  set_tests_properties(prove.subset PROPERTIES TIMEOUT 900 SKIP_RETURN_CODE 77)
  add_test(NAME prove.subset_with_ablations COMMAND ${subset} 5 4 1)
  set_tests_properties(prove.subset_with_ablations PROPERTIES LABELS long TIMEOUT 1800 SKIP_RETURN_CODE 77)
  add_test(NAME prove.campaign COMMAND ${CMAKE_CURRENT_BINARY_DIR}/omniflight_proof_campaign --cases 240 --nulls 300
           --out ${CMAKE_CURRENT_BINARY_DIR}/campaign --command ${analysis})
  set_tests_properties(prove.campaign PROPERTIES TIMEOUT 36000 LABELS long
                       ENVIRONMENT OMNIFLIGHT_CONFIGS=${PROVE}/../../../configs)
endif()
