// Where a campaign of the proof keeps what.
//   OUT/cases/case-0001/{flight.csv.gz, told.yaml}   what the analysis sees
//   OUT/vehicle/NAME.yaml                            the nominal vehicle
//   OUT/commitment.json                              hashes of truth and recordings, before any analysis
//   OUT/probe.json                                   what the analysis could not do
//   OUT/answers/case-0001/{diagnosis.json, run.json, ...}
//   OUT/answers.sha256                               freezes the answers; its own hash is printed
//   OUT/next/case-0001/..., OUT/answers_next/case-0001/..., OUT/answers_next.sha256   the flight an answer
//   asked for
//   OUT/ablations/late-pose/case-0001/..., OUT/ablations.sha256   answers without a safeguard, of some cases
//   OUT/oracle.json, OUT/proof.json, OUT/report.html   after the seal was opened
//   SEAL/truth.json   mode 600, in a folder of mode 700
#pragma once

#include <filesystem>

namespace omniflight::proof {

struct Places {
  std::filesystem::path out, seal;
  std::filesystem::path cases() const { return out / "cases"; }
  std::filesystem::path answers() const { return out / "answers"; }
  std::filesystem::path commitment() const { return out / "commitment.json"; }
  std::filesystem::path probe() const { return out / "probe.json"; }
  std::filesystem::path frozen() const { return out / "answers.sha256"; }
  std::filesystem::path next() const { return out / "next"; }
  std::filesystem::path answers_next() const { return out / "answers_next"; }
  std::filesystem::path frozen_next() const { return out / "answers_next.sha256"; }
  std::filesystem::path ablations() const { return out / "ablations"; }
  std::filesystem::path frozen_ablations() const { return out / "ablations.sha256"; }
  std::filesystem::path oracle() const { return out / "oracle.json"; }
  std::filesystem::path truth() const { return seal / "truth.json"; }
};

}  // namespace omniflight::proof
