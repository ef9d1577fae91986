#include "load_all.hpp"

#include "omniflight_recording/axes.hpp"
#include "omniflight_recording/formats.hpp"

namespace omniflight::cli {

Result<recording::Recording> load_as(const std::string& path, const ReadAs& as) {
  auto r = recording::load(path, {.map = as.map});
  if (r && as.axes == "ned")
    if (auto ok = recording::turn_from_ned(*r); !ok) return Failure(ok.error());
  return r;
}

Result<std::vector<recording::Recording>> load_all(const std::vector<std::string>& paths, const ReadAs& as) {
  std::vector<recording::Recording> out;
  for (const std::string& path : paths) {
    auto r = load_as(path, as);
    if (!r) return Failure(r.error());
    out.push_back(std::move(*r));
  }
  return out;
}

}  // namespace omniflight::cli
