// Makes one case: turns its effects to their size, flies it, and writes what may be seen and what may not.
#pragma once

#include <string>

#include "case_draw.hpp"

namespace omniflight::proof {

/// Bytes of every recording, whatever is in it.
inline constexpr std::size_t kRecordingBytes = 8u << 20;

struct MadeCase {
  std::string recording;  ///< canonical CSV, gzip, kRecordingBytes long
  std::string told;       ///< told.yaml: the same keys and the same length in every case
  Truth truth;
};

/// salt: of the draw. Errors: a flight that is lost at every size of its effects, naming the case.
Result<MadeCase> make_case(const vehicle::Vehicle& vehicle, const std::vector<Mechanism>& mechanisms,
                           const CasePlan& plan, const std::string& salt, bool sealed);
/// The same concealed world once more, along another path and with other noise; the truth stays empty.
Result<MadeCase> fly_again(const vehicle::Vehicle& vehicle, const std::vector<Mechanism>& mechanisms,
                           const CasePlan& plan, const std::string& salt, bool sealed, const Path& path);

}  // namespace omniflight::proof
