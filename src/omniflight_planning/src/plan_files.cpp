#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "omniflight_files/files.hpp"
#include "omniflight_planning/plan.hpp"
#include "plan_reader.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kMaxPlanFile = 256 * files::kMegabyte;
constexpr std::size_t kMaxOverrides = 1000;

Json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json to_json(const Trajectory& trajectory) {
  Json knots = Json::array();
  for (const auto& knot : trajectory.knots()) {
    const Reference& r = knot.reference;
    knots.push_back({{"t", knot.t},
                     {"p", array(r.p_WB)},
                     {"q", {r.q_WB.w(), r.q_WB.x(), r.q_WB.y(), r.q_WB.z()}},
                     {"v", array(r.v_WB_W)},
                     {"w", array(r.w_WB_B)},
                     {"a", array(r.a_WB_W)},
                     {"dw", array(r.dw_WB_B)},
                     {"alpha", r.alpha}});
  }
  return {{"schema", "omniflight.trajectory/1"},
          {"frames",
           "p, v, a in the world [m, m/s, m/s2]; q = w x y z, world <- body; w, dw in the body [rad/s, "
           "rad/s2]; alpha [rad]; t [s]"},
          {"duration_s", trajectory.duration()},
          {"knots", std::move(knots)}};
}

Json to_json(const FlightState& s) {
  const Reference& r = s.reference;
  return {{"p", array(r.p_WB)},   {"q", {r.q_WB.w(), r.q_WB.x(), r.q_WB.y(), r.q_WB.z()}},
          {"v", array(r.v_WB_W)}, {"w", array(r.w_WB_B)},
          {"a", array(r.a_WB_W)}, {"dw", array(r.dw_WB_B)},
          {"j", array(s.j_WB_W)},  // m/s^3, world
          {"alpha", r.alpha}};
}

Json to_json(const TetherUse& use) {
  return {{"length_m", use.length},
          {"longest_m", use.longest},
          {"twist_deg", to_degrees(use.twist)},
          {"mass_kg", use.mass}};
}

Json to_json(const Certificate& c, const std::string& trajectory_sha256) {
  Json out{{"schema", "omniflight.certificate/1"},
           {"verdict", c.verdict},
           {"reason", c.reason},
           {"mission", {{"name", c.mission}, {"file", c.mission_file}, {"sha256", c.mission_sha256}}},
           {"vehicle",
            {{"name", c.vehicle},
             {"file", c.vehicle_file},
             {"set", c.vehicle_set},
             {"sha256", c.vehicle_sha256},
             {"mass_kg", c.vehicle_mass}}},
           {"map", {{"file", c.map_file}, {"sha256", c.map_sha256}}},
           {"trajectory", {{"sha256", trajectory_sha256}}},
           {"seed", c.seed},
           {"planner", c.planner},
           {"threads", c.threads},
           {"alpha_deg", to_degrees(c.alpha)},
           {"alpha_range_deg", {to_degrees(c.alpha_lowest), to_degrees(c.alpha_highest)}},
           {"alpha_searched", c.alpha_searched},
           {"attitude", {{"from_acceleration", c.leans}, {"thrust_axis", array(c.thrust_axis_B)}}},
           {"duration_s", c.duration},
           {"clearance",
            {{"asked_m", c.clearance_asked},
             {"min_m", c.min_clearance},
             {"min_at_s", c.min_clearance_at},
             {"horizon_m", c.clearance_horizon},
             {"witnesses", c.witnesses}}},
           {"tube",
            {{"position_m", c.tube.position},
             {"attitude_deg", to_degrees(c.tube.attitude)},
             {"in_margin", c.tube.in_margin},
             {"margin_m", c.tube_margin},
             {"file", c.tube.file},
             {"sha256", c.tube.sha256}}},
           {"rotors",
            {{"headroom_asked", c.limits.rotor_headroom},
             {"min_headroom", 1.0 - c.peak.rotor_load},
             {"min_headroom_at_s", c.peak.rotor_load_at},
             {"max_thrust_rate", c.peak.thrust_rate.share},  // share of what the motors' lag allows
             {"max_thrust_rate_at_s", c.peak.thrust_rate_at},
             {"max_thrust_rate_rotor", c.peak.thrust_rate.rotor}}},
           {"limits",
            {{"speed_mps", c.limits.speed},
             {"acceleration_mps2", c.limits.acceleration},
             {"rate_dps", to_degrees(c.limits.rate)},
             {"angular_acceleration_dps2", to_degrees(c.limits.angular_acceleration)},
             {"lean_deg", to_degrees(c.limits.lean)}}},
           {"max",
            {{"speed_mps", c.peak.speed},
             {"acceleration_mps2", c.peak.acceleration},
             {"rate_dps", to_degrees(c.peak.rate)},
             {"angular_acceleration_dps2", to_degrees(c.peak.angular_acceleration)},
             {"lean_deg", to_degrees(c.peak.lean)},
             {"tilt_rate_dps", to_degrees(c.peak_tilt_rate)}}},
           {"tilts_in_flight", c.tilts_in_flight}};
  if (c.energy) out["energy_J"] = *c.energy;
  if (c.from) out["from"] = to_json(*c.from);
  if (c.tether) out["tether"] = to_json(*c.tether);
  if (c.payload) out["payload"] = {{"mass_kg", c.payload->mass}, {"position_m", array(c.payload->p_B)}};
  return out;
}

void append_number(std::string& out, const char* format, double value) {
  char number[40];
  std::snprintf(number, sizeof number, format, value);
  out += number;
}

std::string to_csv(const Plan& plan) {
  std::string out =
      "t_s,ref_px_m,ref_py_m,ref_pz_m,ref_qw,ref_qx,ref_qy,ref_qz,ref_vx_mps,ref_vy_mps,ref_vz_mps,"
      "ref_wx_radps,ref_wy_radps,ref_wz_radps,ref_ax_mps2,ref_ay_mps2,ref_az_mps2,"
      "ref_dwx_radps2,ref_dwy_radps2,ref_dwz_radps2,alpha_cmd_rad,ref_jx_mps3,ref_jy_mps3,ref_jz_mps3";
  const Eigen::Index rotors = plan.figures.empty() ? 0 : plan.figures.front().thrusts.size();
  for (Eigen::Index i = 1; i <= rotors; ++i) out += ",u" + std::to_string(i) + "_N";
  if (!plan.figures.empty()) out += ",clearance_m,headroom";
  out += '\n';
  const auto& knots = plan.trajectory.knots();
  for (std::size_t k = 0; k < knots.size(); ++k) {
    const Reference& r = knots[k].reference;
    const Vec3 q_xyz = r.q_WB.vec();
    const Vec3 jerk = k + 1 < knots.size() ? jerk_between(knots[k], knots[k + 1], 0.0) : Vec3(Vec3::Zero());
    Eigen::Matrix<double, 24, 1> row;
    row << knots[k].t, r.p_WB, r.q_WB.w(), q_xyz, r.v_WB_W, r.w_WB_B, r.a_WB_W, r.dw_WB_B, r.alpha, jerk;
    for (int i = 0; i < row.size(); ++i) append_number(out, i == 0 ? "%.6f" : ",%.9g", row[i]);
    if (k < plan.figures.size()) {
      const KnotFigures& f = plan.figures[k];
      for (const double thrust : f.thrusts) append_number(out, ",%.6g", thrust);
      append_number(out, ",%.6g", f.clearance);
      append_number(out, ",%.6g", f.headroom);
    } else if (!plan.figures.empty()) {  // the budget ended before: no sample
      out.append(static_cast<std::size_t>(rotors) + 2, ',');
    }
    out += '\n';
  }
  return out;
}

Reference reference_of(PlanReader& r, const Json& item) {
  Reference ref;
  ref.p_WB = r.numbers<3>(item, "p", 1e4);
  const Eigen::Vector4d q = r.numbers<4>(item, "q", 1.0 + 1e-6);
  ref.q_WB = Quat(q[0], q[1], q[2], q[3]);
  ref.v_WB_W = r.numbers<3>(item, "v", 1e3);
  ref.w_WB_B = r.numbers<3>(item, "w", 1e3);
  ref.a_WB_W = r.numbers<3>(item, "a", 1e4);
  ref.dw_WB_B = r.numbers<3>(item, "dw", 1e5);
  ref.alpha = r.number(item, "alpha", -kPi, kPi);
  return ref;
}

Result<Json> parse(const std::string& bytes, const std::string& file) {
  Json json = Json::parse(bytes, nullptr, false);
  if (json.is_discarded() || !json.is_object()) return bad_input("is no JSON object", file, kPlanAgain);
  return json;
}

}  // namespace

Status write_plan(const Plan& plan, const std::filesystem::path& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error)
    return bad_input("the folder cannot be made: " + error.message(), dir.string(), "Choose another --out");
  const std::string trajectory = to_json(plan.trajectory).dump() + "\n";
  if (auto ok = files::write_file_atomic(dir / "trajectory.json", trajectory); !ok) return ok;
  if (auto ok = files::write_file_atomic(dir / "trajectory.csv", to_csv(plan)); !ok) return ok;
  return files::write_file_atomic(dir / "certificate.json",
                                  to_json(plan.certificate, files::sha256_hex(trajectory)).dump(2) + "\n");
}

Result<Plan> read_plan(const std::filesystem::path& dir) {
  const std::string trajectory_file = (dir / "trajectory.json").string();
  const std::string certificate_file = (dir / "certificate.json").string();
  const auto bytes = files::read_file(trajectory_file, kMaxPlanFile);
  if (!bytes) return Failure(bytes.error());
  const auto certificate_bytes = files::read_file(certificate_file, files::kMegabyte);
  if (!certificate_bytes) return Failure(certificate_bytes.error());
  const auto certificate = parse(*certificate_bytes, certificate_file);
  if (!certificate) return Failure(certificate.error());

  PlanReader c(certificate_file);
  Plan out;
  Certificate& o = out.certificate;
  if (c.string(*certificate, "schema") != "omniflight.certificate/1")
    c.refuse("schema", "is not omniflight.certificate/1");
  o.verdict = c.string(*certificate, "verdict");
  o.reason = c.string(*certificate, "reason");
  const Json &mission = c.object(*certificate, "mission"), &vehicle = c.object(*certificate, "vehicle"),
             &map = c.object(*certificate, "map"), &limits = c.object(*certificate, "limits"),
             &max = c.object(*certificate, "max"), &clearance = c.object(*certificate, "clearance"),
             &rotors = c.object(*certificate, "rotors");
  o.mission = c.string(mission, "name");
  o.mission_file = c.string(mission, "file");
  o.mission_sha256 = c.string(mission, "sha256");
  o.vehicle = c.string(vehicle, "name");
  o.vehicle_file = c.string(vehicle, "file");
  o.vehicle_sha256 = c.string(vehicle, "sha256");
  if (vehicle.contains("set")) o.vehicle_set = c.strings(vehicle, "set", kMaxOverrides);
  o.vehicle_mass = c.number(vehicle, "mass_kg", 0.0, 1e4);
  o.map_file = c.string(map, "file");
  o.map_sha256 = c.string(map, "sha256");
  o.seed = static_cast<std::uint64_t>(c.number(*certificate, "seed", 0.0, 9e15));
  if (certificate->contains("planner")) o.planner = c.string(*certificate, "planner");
  if (certificate->contains("threads"))
    o.threads = static_cast<int>(c.number(*certificate, "threads", 1.0, 1e3));
  if (certificate->contains("from")) {  // plans that begin in flight
    const Json& from = c.object(*certificate, "from");
    o.from = {.reference = reference_of(c, from), .j_WB_W = c.numbers<3>(from, "j", 1e6)};
    if (std::abs(o.from->reference.q_WB.norm() - 1.0) > 1e-6) c.refuse("from.q", "is not of unit length");
  }
  o.alpha = to_radians(c.number(*certificate, "alpha_deg", -180.0, 180.0));
  o.alpha_lowest = o.alpha_highest = o.alpha;
  if (certificate->contains("alpha_range_deg")) {  // not in plans made before the tilt could move
    const Eigen::Vector2d range = c.numbers<2>(*certificate, "alpha_range_deg", 180.0);
    o.alpha_lowest = to_radians(range[0]), o.alpha_highest = to_radians(range[1]);
  }
  if (const auto searched = certificate->find("alpha_searched");
      searched != certificate->end() && searched->is_boolean())
    o.alpha_searched = searched->get<bool>();
  if (certificate->contains("tilts_in_flight")) {  // not in plans made before it could be
    const Json& in_flight = (*certificate)["tilts_in_flight"];
    if (!in_flight.is_boolean()) c.refuse("tilts_in_flight", "is neither true nor false");
    o.tilts_in_flight = in_flight.is_boolean() && in_flight.get<bool>();
    o.peak_tilt_rate = to_radians(c.number(max, "tilt_rate_dps", 0.0, 1e5));
  }
  o.duration = c.number(*certificate, "duration_s", 0.0, 1e5);
  if (certificate->contains("energy_J")) o.energy = c.number(*certificate, "energy_J", 0.0, 1e12);
  o.clearance_asked = c.number(clearance, "asked_m", 0.0, 100.0);
  o.min_clearance = c.number(clearance, "min_m", 0.0, 100.0);
  o.min_clearance_at = c.number(clearance, "min_at_s", 0.0, 1e5);
  o.clearance_horizon = c.number(clearance, "horizon_m", 0.0, 100.0);
  o.witnesses = static_cast<std::size_t>(c.number(clearance, "witnesses", 0.0, 1e12));
  o.limits.rotor_headroom = c.number(rotors, "headroom_asked", 0.0, 1.0);
  o.peak.rotor_load = 1.0 - c.number(rotors, "min_headroom", -1e6, 1.0);
  o.peak.rotor_load_at = c.number(rotors, "min_headroom_at_s", 0.0, 1e5);
  if (rotors.contains("max_thrust_rate")) {  // not in plans made before the motors' lag was a limit
    o.peak.thrust_rate.share = c.number(rotors, "max_thrust_rate", 0.0, 1e6);
    o.peak.thrust_rate.rotor =
        static_cast<int>(c.number(rotors, "max_thrust_rate_rotor", 0.0, vehicle::kMaxRotors));
    o.peak.thrust_rate_at = c.number(rotors, "max_thrust_rate_at_s", 0.0, 1e5);
  }
  o.limits.speed = c.number(limits, "speed_mps", 0.0, 1e3);
  o.limits.acceleration = c.number(limits, "acceleration_mps2", 0.0, 1e4);
  o.limits.rate = to_radians(c.number(limits, "rate_dps", 0.0, 1e5));
  o.limits.angular_acceleration = to_radians(c.number(limits, "angular_acceleration_dps2", 0.0, 1e7));
  o.peak.speed = c.number(max, "speed_mps", 0.0, 1e3);
  o.peak.acceleration = c.number(max, "acceleration_mps2", 0.0, 1e4);
  o.peak.rate = to_radians(c.number(max, "rate_dps", 0.0, 1e5));
  o.peak.angular_acceleration = to_radians(c.number(max, "angular_acceleration_dps2", 0.0, 1e7));
  if (certificate->contains("tube")) {  // not in older plans
    const Json& tube = c.object(*certificate, "tube");
    o.tube.position = c.number(tube, "position_m", 0.0, 100.0);
    o.tube.attitude = to_radians(c.number(tube, "attitude_deg", 0.0, 180.0));
    if (tube.contains("in_margin")) {  // not in plans made before it could be
      const auto& in_margin = tube["in_margin"];
      if (in_margin.is_boolean())
        o.tube.in_margin = in_margin.get<bool>();
      else
        c.refuse("tube.in_margin", "is neither true nor false");
      o.tube_margin = c.number(tube, "margin_m", 0.0, 1e4);
      o.tube.file = c.string(tube, "file");
      o.tube.sha256 = c.string(tube, "sha256");
    }
  }
  if (certificate->contains("attitude")) {  // not in plans made before vehicles could lean into their motion
    const Json& attitude = c.object(*certificate, "attitude");
    const auto leans = attitude.find("from_acceleration");
    if (leans == attitude.end() || !leans->is_boolean())
      c.refuse("attitude.from_acceleration", "is neither true nor false");
    else
      o.leans = leans->get<bool>();
    o.thrust_axis_B = c.numbers<3>(attitude, "thrust_axis", 1.0 + 1e-9);
    if (o.leans && std::abs(o.thrust_axis_B.norm() - 1.0) > 1e-6)
      c.refuse("attitude.thrust_axis", "is not of unit length");
    o.limits.lean = to_radians(c.number(limits, "lean_deg", 0.0, 180.0));
    o.peak.lean = to_radians(c.number(max, "lean_deg", 0.0, 180.0));
  }
  if (certificate->contains("tether")) {
    const Json& tether = c.object(*certificate, "tether");
    o.tether = {.length = c.number(tether, "length_m", 0.0, 1e4),
                .longest = c.number(tether, "longest_m", 0.0, 1e4),
                .twist = to_radians(c.number(tether, "twist_deg", 0.0, 1e9)),
                .mass = c.number(tether, "mass_kg", 0.0, 1e5)};
  }
  if (certificate->contains("payload")) {
    const Json& payload = c.object(*certificate, "payload");
    o.payload = {.mass = c.number(payload, "mass_kg", 0.0, 1e3),
                 .p_B = c.numbers<3>(payload, "position_m", 10.0)};
  }
  const std::string hash = c.string(c.object(*certificate, "trajectory"), "sha256");
  if (!c.ok()) return c.failure();
  if (hash != files::sha256_hex(*bytes))
    return bad_input("the trajectory is not the one its certificate speaks of: the hashes differ",
                     trajectory_file, kPlanAgain);

  const auto json = parse(*bytes, trajectory_file);
  if (!json) return Failure(json.error());
  PlanReader r(trajectory_file);
  if (r.string(*json, "schema") != "omniflight.trajectory/1")
    r.refuse("schema", "is not omniflight.trajectory/1");
  const Json& list = r.object(*json, "knots");
  if (!list.is_array() || list.empty() || list.size() > kMaxKnots)
    r.refuse("knots", "holds no knot or more than a million");
  if (!r.ok()) return r.failure();
  std::vector<TrajectoryKnot> knots;
  knots.reserve(list.size());
  for (const Json& item : list) {
    r.at("knots[" + std::to_string(knots.size()) + "]");
    TrajectoryKnot knot;
    knot.t = r.number(item, "t", 0.0, 1e5);
    knot.reference = reference_of(r, item);
    if (!r.ok()) return r.failure();
    knots.push_back(knot);
  }
  auto trajectory = Trajectory::create(std::move(knots));
  if (!trajectory) {
    Error error = trajectory.error();
    error.where = trajectory_file + ": " + error.where;
    return Failure(error);
  }
  out.trajectory = std::move(*trajectory);
  return out;
}

}  // namespace omniflight::planning
