# The concealed-effect proof. Three programs that share a file format and nothing else: the generator (with the plant),
# the campaign that runs the analysis where it cannot read the truth, and the scorer.
find_package(omniflight_recording REQUIRED)
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

add_library(omniflight_proof_cases STATIC
  ${PROVE}/case_path.cpp ${PROVE}/case_log.cpp ${PROVE}/case_flight.cpp ${PROVE}/case_mechanism.cpp
  ${PROVE}/case_unknown.cpp ${PROVE}/case_draw.cpp ${PROVE}/case_make.cpp)
target_link_libraries(omniflight_proof_cases PUBLIC omniflight_proof omniflight_proof_protocol
  omniflight_control::omniflight_control omniflight_allocation::omniflight_allocation
  omniflight_recording::omniflight_recording PRIVATE Threads::Threads omniflight_warnings)
omniflight_executable(omniflight_proof_generate ${PROVE}/prove_generate.cpp
  LINK omniflight_proof_cases CLI11::CLI11)
