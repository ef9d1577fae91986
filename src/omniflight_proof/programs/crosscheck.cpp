// Flies nominal missions in the simulator and in MuJoCo, as separate processes, and compares the recordings;
// weighs the articulated cable over height; measures the real-time factor.
#include <fmt/format.h>
#include <sys/wait.h>
#include <CLI/CLI.hpp>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>

#include "omniflight_files/files.hpp"
#include "report.hpp"

namespace {

using namespace omniflight;
using namespace omniflight::proof;
namespace fs = std::filesystem;

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

Status run(const std::string& command) {
  const int status = std::system(command.c_str());
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
  if (code == 0) return {};
  return fail(code == 4 ? ErrorCode::bad_input : ErrorCode::incomplete,
              "ended with exit code " + std::to_string(code), command, "Run it by hand to see why");
}

Result<FlightDifference> fly_both(const std::string& program, const std::string& mission, const fs::path& out,
                                  const vehicle::Vehicle& vehicle) {
  const std::string name = fs::path(mission).stem().string();
  const fs::path simulated = out / (name + "-simulator"), mujoco = out / (name + "-mujoco");
  const std::string common = quoted(program) + " fly " + quoted(mission) + " --sensors ideal --quiet";
  if (auto ok = run(common + " --plant simulator --out " + quoted(simulated.string())); !ok)
    return Failure(ok.error());
  if (auto ok = run(common + " --plant mujoco --plan " + quoted((simulated / "plan").string()) + " --out " +
                    quoted(mujoco.string()));
      !ok)
    return Failure(ok.error());
  auto difference = compare_flights(simulated / "flight.mcap", mujoco / "flight.mcap", vehicle);
  if (difference) difference->mission = name;
  return difference;
}

/// Simulated seconds per second of processor time, with the body on a rail that goes up slowly.
Result<RealTimeFactor> measure_speed(const std::string& name, const vehicle::Vehicle& vehicle,
                                     const World& world, double seconds) {
  PlantOptions options;
  options.initial.p_WB.z() = 1.0;
  auto plant = MujocoPlant::create(vehicle, world, options);
  if (!plant) return Failure(plant.error());
  const auto hover = std::sqrt(vehicle.mass * kGravity / static_cast<double>(vehicle.rotors.size()) /
                               vehicle.rotors.front().thrust_coefficient);
  const std::vector<double> speeds(vehicle.rotors.size(), hover);
  plant->set_command(speeds, 0);
  RigidState hold = options.initial;
  const std::clock_t begin = std::clock();
  const long steps = std::lround(seconds / options.step);
  for (long k = 0; k < steps; ++k) {
    if (world.articulated()) {
      hold.p_WB.z() += 1e-4;
      plant->hold_at(hold);
    }
    if (auto ok = plant->step(world.articulated()); !ok) return Failure(ok.error());
  }
  const double used = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return RealTimeFactor{name, seconds / std::max(1e-9, used)};
}

struct Options {
  std::string out = "runs/crosscheck", program = "omniflight", cable;
  std::vector<std::string> missions{"trajectory_1", "trajectory_2", "full_roll"};
  bool no_flights = false, no_cable = false, json = false;
};

/// Hung mass over height, and how fast this world and the nominal one go.
Status weigh(const vehicle::Vehicle& vehicle, const World& world, CrossCheck& result) {
  auto cable = measure_hung_mass(vehicle, world, {});
  if (!cable) return Failure(cable.error());
  result.cable = std::move(*cable);
  const std::tuple<const char*, World, double> worlds[] = {{"nominal", World{}, 20.0}, {"cable", world, 4.0}};
  for (const auto& [name, w, seconds] : worlds) {
    auto factor = measure_speed(name, vehicle, w, seconds);
    if (!factor) return Failure(factor.error());
    result.speeds.push_back(*factor);
  }
  return {};
}

Result<int> check(const Options& o) {
  const fs::path out = fs::absolute(o.out);
  std::error_code ec;
  fs::create_directories(out, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), out.string());
  auto vehicle = vehicle::load_vehicle("omnimorph");
  if (!vehicle) return Failure(vehicle.error());
  auto configs = files::config_dir();
  if (!configs) return Failure(configs.error());
  auto world = load_world(o.cable.empty() ? *configs / "proof_worlds" / "cable.yaml" : fs::path(o.cable));
  if (!world) return Failure(world.error());

  CrossCheck result;
  if (!o.no_flights) {
    for (const std::string& mission : o.missions) {
      auto difference = fly_both(o.program, mission, out, *vehicle);
      if (!difference) return Failure(difference.error());
      result.flights.push_back(std::move(*difference));
    }
  }
  if (!o.no_cable)
    if (auto ok = weigh(*vehicle, *world, result); !ok) return Failure(ok.error());
  const std::string json = to_json(result).dump(2) + "\n";
  if (auto ok = files::write_file_atomic(out / "crosscheck.json", json); !ok) return Failure(ok.error());
  if (auto ok = write_report(result, out / "report.html"); !ok) return Failure(ok.error());
  if (o.json) std::cout << json;
  for (const FlightDifference& f : result.flights)
    std::cerr << fmt::format("{}: position {:.4f} mm, attitude {:.5f} deg, power {:+.4f} %\n", f.mission,
                             1e3 * f.position_rmse, f.attitude_rmse_deg, 100 * (f.power_ratio() - 1));
  for (const HungMass::Rest& r : result.cable.rests)
    std::cerr << fmt::format("cable at {:.2f} m {}: {:.4f} kg, law {:.4f} kg ({:+.1f} %)\n", r.height,
                             r.upward ? "up" : "down", r.mass, r.expected, 100 * (r.mass / r.expected - 1));
  if (!o.no_cable) std::cerr << fmt::format("cable, hysteresis: {:.1f} %\n", 100 * result.cable.hysteresis());
  for (const RealTimeFactor& s : result.speeds)
    std::cerr << fmt::format("{}: {:.1f} times real time\n", s.world, s.factor);
  for (const std::string& f : result.failures()) std::cerr << "differs: " << f << "\n";
  std::cerr << "report: " << (out / "report.html").string() << "\n";
  return result.failures().empty() ? 0 : static_cast<int>(ErrorCode::incomplete);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Cross-check of the simulator and the MuJoCo plant.\n"
      "Example: omniflight_proof_crosscheck --out crosscheck");
  Options o;
  app.add_option("--out", o.out, "Folder for flights, crosscheck.json and report.html");
  app.add_option("--program", o.program, "The omniflight command");
  app.add_option("--missions", o.missions, "Missions flown in both worlds")->delimiter(',');
  app.add_option("--cable", o.cable, "World with a cable; otherwise configs/proof_worlds/cable.yaml");
  app.add_flag("--no-flights", o.no_flights, "Only the cable and the real-time factor");
  app.add_flag("--no-cable", o.no_cable, "Only the flights");
  app.add_flag("--json", o.json, "crosscheck.json on stdout");
  CLI11_PARSE(app, argc, argv);
  auto code = check(o);
  if (code) return *code;
  std::cerr << "omniflight_proof_crosscheck: " << code.error().text() << "\n";
  return static_cast<int>(code.error().code);
}
