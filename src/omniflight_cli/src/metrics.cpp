#include "metrics.hpp"

namespace omniflight::cli {

nlohmann::json to_json(const FlightMetrics& m) {
  const auto tracking = [](const Tracking& t) {
    nlohmann::json out{
        {"position_rmse_m",
         {{"x", t.position_rmse.x()}, {"y", t.position_rmse.y()}, {"z", t.position_rmse.z()}}},
        {"attitude_rmse_deg",
         {{"roll", t.attitude_rmse.x()}, {"pitch", t.attitude_rmse.y()}, {"yaw", t.attitude_rmse.z()}}},
        {"worst_position_m", t.worst_position},
        {"worst_attitude_deg", t.worst_attitude}};
    if (t.left_at) out["left_reference_at_s"] = *t.left_at;
    return out;
  };
  nlohmann::json j{{"window_s", {m.from, m.to}},
                   {"measured", tracking(m.measured)},
                   {"power_W", m.mean_power},
                   {"power_thesis_convention", m.thesis_power}};
  if (m.has_truth) j["true"] = tracking(m.truth);
  if (m.has_integral)
    j["mean_integral_action"] = std::vector<double>(m.mean_integral.data(), m.mean_integral.data() + 6);
  return j;
}

}  // namespace omniflight::cli
