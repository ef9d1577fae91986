#include "omniflight_diagnosis/neighbour_file.hpp"

#include "omniflight_recording/formats.hpp"

namespace omniflight::diagnosis {

Result<physics::NeighbourTrack> load_neighbour(const std::string& path, const std::filesystem::path& map,
                                               double origin) {
  recording::LoadOptions load;
  load.map = map;
  const auto r = recording::load(path, load);
  if (!r) return Failure(r.error());
  const recording::Signal* p = r->find("position");
  if (!p || p->width() != 3)
    return bad_input("has no position", path, "A neighbour needs px_m, py_m and pz_m");
  physics::NeighbourTrack track;
  for (Eigen::Index i = 0; i < p->size(); ++i) {
    track.t_s.push_back(p->t_s[static_cast<std::size_t>(i)] + r->start_s - origin);
    track.p_WN.push_back(p->values.row(i).transpose());
  }
  if (auto ok = physics::validate(track); !ok) {
    Error error = ok.error();
    error.where = path + ": " + error.where;
    return Failure(error);
  }
  return track;
}

}  // namespace omniflight::diagnosis
