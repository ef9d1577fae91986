# Families: worlds that differ in everything an analysis could get used to, and what scores answers by family.
set(FAMILIES ${CMAKE_CURRENT_LIST_DIR})

add_library(omniflight_proof_family_truth STATIC ${FAMILIES}/family_truth.cpp ${FAMILIES}/family_aliases.cpp
  ${FAMILIES}/family_publish.cpp)
target_include_directories(omniflight_proof_family_truth PUBLIC ${FAMILIES})
target_link_libraries(omniflight_proof_family_truth PUBLIC omniflight_proof_protocol PRIVATE omniflight_warnings)

add_library(omniflight_proof_family_cases STATIC
  ${FAMILIES}/family_vehicle.cpp ${FAMILIES}/family_control.cpp ${FAMILIES}/family_path.cpp ${FAMILIES}/family_log.cpp
  ${FAMILIES}/family_flight.cpp ${FAMILIES}/family_laboratory.cpp ${FAMILIES}/family_draw.cpp ${FAMILIES}/family_make.cpp
  ${FAMILIES}/family_oracle.cpp ${FAMILIES}/family_columns.cpp ${FAMILIES}/hidden.cpp ${FAMILIES}/hidden_body.cpp ${FAMILIES}/hidden_propeller.cpp ${FAMILIES}/hidden_actuation.cpp
  ${FAMILIES}/hidden_air.cpp ${FAMILIES}/hidden_boundary.cpp ${FAMILIES}/hidden_cable.cpp ${FAMILIES}/hidden_load.cpp
  ${FAMILIES}/hidden_spring.cpp ${FAMILIES}/hidden_inertial.cpp ${FAMILIES}/hidden_sensing.cpp ${FAMILIES}/hidden_unknown.cpp)
target_link_libraries(omniflight_proof_family_cases PUBLIC omniflight_proof omniflight_proof_paths omniflight_proof_family_truth
  omniflight_control::omniflight_control omniflight_recording::omniflight_recording PRIVATE Threads::Threads omniflight_warnings)
add_library(omniflight_proof_injection STATIC ${FAMILIES}/injection.cpp ${FAMILIES}/injectable.cpp)
target_link_libraries(omniflight_proof_injection PUBLIC omniflight_proof_paths omniflight_proof_family_truth
  omniflight_recording::omniflight_recording omniflight_vehicle::omniflight_vehicle PRIVATE omniflight_warnings)
omniflight_executable(omniflight_proof_inject ${FAMILIES}/families_inject.cpp LINK omniflight_proof_injection CLI11::CLI11)
omniflight_executable(omniflight_proof_families ${FAMILIES}/families_generate.cpp
  LINK omniflight_proof_family_cases CLI11::CLI11)

add_library(omniflight_proof_family_scores STATIC ${FAMILIES}/family_judge.cpp ${FAMILIES}/family_scores.cpp
  ${FAMILIES}/family_result.cpp)
target_link_libraries(omniflight_proof_family_scores PUBLIC omniflight_proof_family_truth
  omniflight_report::omniflight_report PRIVATE omniflight_warnings)
omniflight_executable(omniflight_proof_families_score ${FAMILIES}/families_score.cpp
  LINK omniflight_proof_family_scores CLI11::CLI11)
foreach(_library family_truth family_cases injection family_scores)
  omniflight_join(omniflight_proof_${_library})
  omniflight_precompile(omniflight_proof_${_library} REUSE_FROM omniflight_proof)
endforeach()

if(BUILD_TESTING)
  foreach(test test_families test_family_scores test_injection)
    add_executable(${test} ${FAMILIES}/test/${test}.cpp)
    target_link_libraries(${test} PRIVATE omniflight_proof_family_cases omniflight_proof_family_scores
      omniflight_proof_injection GTest::gtest
      GTest::gtest_main omniflight_warnings)
    target_compile_definitions(${test} PRIVATE OMNIFLIGHT_SOURCE_ROOT="${FAMILIES}/../../..")
    gtest_discover_tests(${test} DISCOVERY_MODE PRE_TEST PROPERTIES TIMEOUT 120)
  endforeach()
  add_test(NAME families.subset COMMAND ${OMNIFLIGHT_PYTHON} -B ${FAMILIES}/test/families_subset.py ${CMAKE_CURRENT_BINARY_DIR})
  set_tests_properties(families.subset PROPERTIES TIMEOUT 600)
  add_test(NAME families.sealed COMMAND ${OMNIFLIGHT_PYTHON} -B ${FAMILIES}/test/families_sealed.py ${CMAKE_CURRENT_BINARY_DIR}
           ${CMAKE_INSTALL_PREFIX}/../omniflight_cli/bin/omniflight)
  set_tests_properties(families.sealed PROPERTIES TIMEOUT 1800 SKIP_RETURN_CODE 77 LABELS long
                       ENVIRONMENT OMNIFLIGHT_CONFIGS=${FAMILIES}/../../../configs)
endif()
