// Truth into the seal, hashes into the commitment.
#pragma once

#include <filesystem>

#include "family.hpp"

namespace omniflight::proof {

/// SEAL/truth.json (mode 600) and OUT/commitment.json: SHA-256 of truth, of OUT/cases, of the alias table and
/// of the program that runs. Completes `seal` with the hash of the program.
Status commit_family_run(const std::filesystem::path& out, const std::filesystem::path& seal_folder,
                         FamilySeal seal);

}  // namespace omniflight::proof
