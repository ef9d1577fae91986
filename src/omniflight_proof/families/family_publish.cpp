#include "family_publish.hpp"

#include <nlohmann/json.hpp>

#include "family_aliases.hpp"
#include "omniflight_files/files.hpp"
#include "seal.hpp"

namespace omniflight::proof {

Status commit_family_run(const std::filesystem::path& out, const std::filesystem::path& seal_folder,
                         FamilySeal seal) {
  if (auto program = files::sha256_file("/proc/self/exe")) seal.program = *program;
  const std::string truth = to_json(seal);
  if (auto ok = write_private(seal_folder / "truth.json", truth); !ok) return ok;
  auto digests = digest_folder(out / "cases");
  if (!digests) return Failure(digests.error());
  const nlohmann::json commitment = {{"schema", "omniflight.proof_commitment/1"},
                                     {"truth_sha256", files::sha256_hex(truth)},
                                     {"recordings_sha256", files::sha256_hex(manifest_text(*digests))},
                                     {"aliases_sha256", files::sha256_hex(family_alias_table())},
                                     {"generator_sha256", seal.program},
                                     {"box", seal.box},
                                     {"cases", seal.cases.size()}};
  return files::write_file_atomic(out / "commitment.json", commitment.dump(1) + "\n");
}

}  // namespace omniflight::proof
