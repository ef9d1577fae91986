#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <set>
#include <thread>

#include "flight.hpp"
#include "folder.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "verb_effects.hpp"

namespace omniflight::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kPlotRate = 25.0;  // Hz, of everything that is plotted

Quat attitude_at(const Eigen::MatrixXd& m, Eigen::Index i) {
  return Quat(m(i, 0), m(i, 1), m(i, 2), m(i, 3));
}

/// What the plots need, so that the recording need not stay in memory.
Status extract(const std::string& file, const FlightMetrics& metrics, GalleryFlight& out) {
  const auto recording = recording::load(file);
  if (!recording) return Failure(recording.error());
  const recording::Recording& r = *recording;
  for (const char* name : {"truth_position", "truth_attitude", "truth_wrench", "truth_rotor_speed",
                           "truth_power", "ref_position", "ref_attitude"})
    if (auto ok = r.require(name); !ok) return Failure(ok.error());
  const recording::Signal& truth = *r.find("truth_position");
  for (double t = truth.t_s.front(); t <= truth.t_s.back(); t += 1.0 / kPlotRate) out.t.push_back(t);
  const auto at = [&](const char* name) { return recording::resample(*r.find(name), out.t, 0.2); };
  const Eigen::MatrixXd p = at("truth_position"), q = at("truth_attitude"), q_ref = at("ref_attitude");
  out.position = p - at("ref_position");
  out.wrench = at("truth_wrench");
  out.rotor_speed = at("truth_rotor_speed");
  const Eigen::MatrixXd power = at("truth_power");
  out.power.assign(power.data(), power.data() + power.rows());
  if (r.find("position")) out.sensed = at("position") - p;
  out.attitude.resize(p.rows(), 3);
  for (Eigen::Index i = 0; i < p.rows(); ++i)
    out.attitude.row(i) =
        log_rotation(attitude_at(q_ref, i).conjugate() * attitude_at(q, i)).transpose() * (180.0 / kPi);
  double sum = 0;
  std::size_t used = 0;
  for (std::size_t i = 0; i < out.t.size(); ++i)
    if (out.t[i] >= metrics.from && out.t[i] <= metrics.to && std::isfinite(out.power[i]))
      sum += out.power[i], ++used;
  out.mean_power = used > 0 ? sum / static_cast<double>(used) : std::nan("");
  const Tracking& tracking = metrics.has_truth ? metrics.truth : metrics.measured;
  out.position_rmse = tracking.position_rmse.norm();
  out.attitude_rmse = tracking.attitude_rmse.norm();
  return {};
}

/// One flight into its own folder; what went wrong stands in the result.
GalleryFlight fly_one(const GalleryOptions& o, const physics::Effect* effect, const std::string& out,
                      const std::string& plan) {
  const auto begin = std::chrono::steady_clock::now();
  GalleryFlight flight;
  flight.effect = effect;
  flight.verdict = "not flown";
  FlightOptions options;
  options.mission = o.mission;
  options.plan = plan;
  options.in_process = true;
  options.quiet = true;
  options.force = true;  // the gallery's own folder, made again as a whole
  options.out = out;
  if (effect) {
    std::vector<double> theta;
    for (const auto& p : effect->info().parameters) theta.push_back(p.typical);
    options.effects = out + "/effect.yaml";
    Status ok = make_folder(out);
    if (ok)
      ok = files::write_file_atomic(
          options.effects,
          physics::model_yaml({{effect, theta}}, "typical values, as the gallery flies them"));
    const auto& signals = effect->info().signals;
    if (ok && std::find(signals.begin(), signals.end(), "neighbour") != signals.end()) {
      options.neighbours = {out + "/neighbour.csv"};  // hovers above the middle of the room
      ok = files::write_file_atomic(options.neighbours[0], "t_s,px_m,py_m,pz_m\n0,0,0,2.5\n");
    }
    if (!ok) {
      flight.reason = ok.error().text();
      return flight;
    }
  }
  auto result = fly(options);
  if (!result) {
    flight.reason = result.error().text();
  } else {
    flight.verdict = result->verdict;
    flight.reason = result->reason;
    if (auto ok = extract(result->recording, result->metrics, flight); !ok && flight.reason.empty())
      flight.reason = ok.error().text();
    std::error_code ec;
    if (!o.keep) fs::remove(result->recording, ec);
  }
  flight.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return flight;
}

nlohmann::json to_json(const GalleryFlight& f) {
  const auto peak = [](const Eigen::MatrixXd& m, int first) {
    double largest = 0;
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      if (m.row(i).allFinite()) largest = std::max(largest, m.row(i).segment<3>(first).norm());
    return largest;
  };
  return {{"effect", f.effect ? f.effect->info().id : "none"},
          {"verdict", f.verdict},
          {"reason", f.reason},
          {"force_peak_N", peak(f.wrench, 0)},
          {"torque_peak_Nm", peak(f.wrench, 3)},
          {"position_rmse_m", f.position_rmse},
          {"attitude_rmse_deg", f.attitude_rmse},
          {"mean_power_W", f.mean_power},
          {"wall_s", f.wall_s}};
}

}  // namespace

Result<int> fly_gallery(const GalleryOptions& o, const Common& common) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<const physics::Effect*> effects;
  for (const std::string& id : o.only) {
    const auto effect = known_effect(id);
    if (!effect) return Failure(effect.error());
    if (std::find(effects.begin(), effects.end(), *effect) == effects.end()) effects.push_back(*effect);
  }
  if (o.only.empty()) effects = physics::builtin_effects();
  const std::string out = common.out.empty() ? fresh_folder("gallery") : common.out;
  if (auto ok = make_folder(out); !ok) return Failure(ok.error());

  std::vector<GalleryFlight> flights(effects.size() + 1);
  Progress progress("gallery", static_cast<double>(flights.size()), "flights", common.quiet);
  flights[0] = fly_one(o, nullptr, out + "/none", "");
  if (flights[0].t.empty())
    return fail(ErrorCode::incomplete,
                "the nominal flight gave nothing to compare with: " + flights[0].reason, "gallery",
                "See the logs in " + out + "/none/log");
  std::atomic<std::size_t> next{1};
  std::size_t done = 1;
  std::mutex mutex;
  progress.update(static_cast<double>(done));
  const auto work = [&] {
    for (std::size_t k = next++; k < flights.size() && !interrupted(); k = next++) {
      GalleryFlight flight =
          fly_one(o, effects[k - 1], out + "/" + effects[k - 1]->info().id, out + "/none/plan");
      const std::lock_guard lock(mutex);
      flights[k] = std::move(flight);
      progress.update(static_cast<double>(++done));
    }
  };
  const int jobs = o.jobs > 0 ? o.jobs : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::thread> threads;
  for (int i = 0; i < jobs; ++i) threads.emplace_back(work);
  for (auto& t : threads) t.join();
  progress.finish();

  const bool whole = done == flights.size();
  std::erase_if(flights, [](const GalleryFlight& f) { return f.verdict.empty(); });  // after Ctrl-C
  const std::string page = out + "/gallery.html";
  if (auto ok = write_gallery(flights, o.mission, page); !ok) return Failure(ok.error());
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  nlohmann::json j{{"schema", "omniflight.gallery/1"},
                   {"mission", o.mission},
                   {"page", page},
                   {"jobs", jobs},
                   {"wall_s", wall},
                   {"flights", nlohmann::json::array()}};
  for (const GalleryFlight& f : flights) {
    j["flights"].push_back(to_json(f));
    const auto& row = j["flights"].back();
    say(common, fmt::format("{:26} {:8.4f} N {:8.5f} Nm  position {:.4f} m  power {:6.1f} W  {}",
                            row["effect"].get<std::string>(), row["force_peak_N"].get<double>(),
                            row["torque_peak_Nm"].get<double>(), f.position_rmse, f.mean_power,
                            f.reason.empty() ? f.verdict : f.verdict + ": " + f.reason));
  }
  if (auto ok = files::write_file_atomic(out + "/gallery.json", j.dump(2) + "\n"); !ok)
    return Failure(ok.error());
  print_json(common, j);
  say(common,
      fmt::format("{} flights in {:.0f} s with {} at once; page: {}", flights.size(), wall, jobs, page));
  return whole ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace omniflight::cli
