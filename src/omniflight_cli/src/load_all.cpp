#include "load_all.hpp"

#include "omniflight_recording/formats.hpp"

namespace omniflight::cli {

Result<std::vector<recording::Recording>> load_all(const std::vector<std::string>& paths,
                                                   const std::string& map) {
  std::vector<recording::Recording> out;
  for (const std::string& path : paths) {
    recording::LoadOptions options;
    options.map = map;
    auto r = recording::load(path, options);
    if (!r) return Failure(r.error());
    out.push_back(std::move(*r));
  }
  return out;
}

}  // namespace omniflight::cli
