// Which source this program was built from.
#pragma once

namespace omniflight::cli {

/// "omniflight 0.2.0 (d2123c1)": the version, and the revision of the source when it was built; "modified"
/// beside it when files had been changed since. Made at build time.
extern const char* const kVersion;

}  // namespace omniflight::cli
