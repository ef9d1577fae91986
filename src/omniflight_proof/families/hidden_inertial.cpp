// Accelerometer and gyroscope.
#include "hidden_sizes.hpp"

namespace omniflight::proof {

void hide_inertial(std::vector<Hidden>& out) {
  out.push_back(
      {.id = "accelerometer_error",
       .stage = "sensing",
       .realisation = "bias beyond what is told",
       .law = true,
       .measure = Measure::formula,
       .smallest = 1e-3,
       .typical = 0.1,
       .largest = 3,
       .possible = has_imu,
       .apply = [](FamilyFlight& f, double a,
                   const Shape& k) { f.world.sensors.accelerometer_bias += a * k.direction(0); },
       .parameters =
           [](const FamilyFlight& f, double a, const Shape& k) {
             return three({"bias_x", "bias_y", "bias_z"}, a * k.direction(0) + f.sensors.accelerometer_bias);
           },
       .size = [](const FamilyFlight& f, double a, const Shape& k,
                  const FamilyFlown&) { return along(mass(f) * a * k.direction(0)); }});
  out.push_back(
      {.id = "accelerometer_error",
       .stage = "sensing",
       .realisation = "scale errors, another on each axis",
       .measure = Measure::formula,
       .smallest = 1e-4,
       .typical = 0.01,
       .largest = 0.2,
       .possible = has_imu,
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             f.world.sensors.accelerometer_scale +=
                 a * Vec3(k.between(0, -1, 1), k.between(1, -1, 1), k.sign(2));
           },
       .size = [](const FamilyFlight& f, double a, const Shape&,
                  const FamilyFlown& n) { return along(mass(f) * a * n.specific_force * Vec3::UnitZ()); }});
  out.push_back({.id = "gyro_error",
                 .stage = "sensing",
                 .realisation = "bias beyond what is told",
                 .law = true,
                 .measure = Measure::formula,
                 .smallest = 1e-4,
                 .typical = 0.01,
                 .largest = 0.5,
                 .possible = has_imu,
                 .apply = [](FamilyFlight& f, double a,
                             const Shape& k) { f.world.sensors.gyro_bias += a * k.direction(0); },
                 .parameters =
                     [](const FamilyFlight& f, double a, const Shape& k) {
                       return three({"bias_x", "bias_y", "bias_z"}, a * k.direction(0) + f.sensors.gyro_bias);
                     },
                 .size =
                     [](const FamilyFlight& f, double a, const Shape& k, const FamilyFlown&) {
                       return own(a * k.direction(0).cwiseAbs().maxCoeff() / f.sensors.gyro_noise);
                     }});
  out.push_back(
      {.id = "gyro_error",
       .stage = "sensing",
       .realisation = "scale error of the gyroscope",
       .measure = Measure::formula,
       .smallest = 1e-3,
       .typical = 0.03,
       .largest = 0.4,
       .possible =
           [](const FamilyVehicle& v, const Coordinates& c) {
             return has_imu(v, c) && c.manoeuvre != "T1" && c.manoeuvre != "T2";
           },
       .apply =
           [](FamilyFlight& f, double a, const Shape& k) {
             f.world.sensors.gyro_scale += a * Vec3(k.sign(0), k.sign(1), k.between(2, -1, 1));
           },
       .size = [](const FamilyFlight& f, double a, const Shape&,
                  const FamilyFlown& n) { return own(a * n.rate / std::sqrt(3.0) / f.sensors.gyro_noise); }});
  const auto lever = [](const FamilyFlight& f, double a, const Shape&, const FamilyFlown& n) {
    return forces(mass(f) * a * n.lever);
  };
  out.push_back({.id = "imu_lever_arm",
                 .stage = "sensing",
                 .realisation = "the IMU off the origin",
                 .law = true,
                 .measure = Measure::formula,
                 .smallest = 1e-4,
                 .typical = 0.02,
                 .largest = 0.3,
                 .possible = has_imu,
                 .apply = [](FamilyFlight& f, double a,
                             const Shape& k) { f.world.sensors.imu_p_B = a * k.direction(0); },
                 .parameters =
                     [](const FamilyFlight&, double a, const Shape& k) {
                       return three({"x", "y", "z"}, a * k.direction(0));
                     },
                 .size = lever});
  out.push_back({.id = "imu_lever_arm",
                 .stage = "sensing",
                 .realisation = "the IMU off the origin, on foam",
                 .measure = Measure::formula,
                 .smallest = 1e-4,
                 .typical = 0.02,
                 .largest = 0.3,
                 .possible = has_imu,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       f.world.sensors.imu_p_B = a * k.direction(0);
                       f.world.sensors.imu_low_pass = 40;
                     },
                 .size = lever,
                 .along = {"sensor_filter"}});
  const auto pass = [](const FamilyFlight& f, double a, const Shape&, const FamilyFlown& n) {
    return late(f, a, n);  // amplitude is the delay [s] of the filter at low frequencies
  };
  out.push_back({.id = "sensor_filter",
                 .stage = "sensing",
                 .realisation = "two poles on accelerometer and gyroscope",
                 .law = true,
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 1e-3,
                 .typical = 0.01,
                 .largest = 0.06,
                 .possible = has_imu,
                 .apply = [](FamilyFlight& f, double a,
                             const Shape&) { f.world.sensors.imu_low_pass = 2 / (2 * kPi * 1.554 * a); },
                 .size = pass});
  out.push_back({.id = "sensor_filter",
                 .stage = "sensing",
                 .realisation = "accelerometer and gyroscope filtered apart",
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 1e-3,
                 .typical = 0.01,
                 .largest = 0.06,
                 .possible = has_imu,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape&) {
                       f.sensors.accelerometer_filter = 2 / (2 * kPi * 1.554 * 1.3 * a);
                       f.sensors.gyro_filter = 2 / (2 * kPi * 1.554 * 0.5 * a);
                     },
                 .size = pass});
  const auto shake = [](const FamilyFlight& f, double a, const Shape&, const FamilyFlown&) {
    // a quarter of full thrust in hover; blocks of 20 ms average what is not aliased to rest
    return forces(mass(f) * a * 0.25 * 0.7 /
                  std::sqrt(std::max(1.0, 0.02 * f.sensors.imu_rate / f.logging.imu_every)));
  };
  out.push_back({.id = "vibration",
                 .stage = "sensing",
                 .realisation = "all rotors out of balance",
                 .law = true,
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 0.05,
                 .typical = 2,
                 .largest = 60,
                 .possible = has_imu,
                 .apply = [](FamilyFlight& f, double a, const Shape&) { f.world.sensors.vibration = a; },
                 .size = shake});
  out.push_back({.id = "vibration",
                 .stage = "sensing",
                 .realisation = "one rotor out of balance",
                 .combines = false,
                 .measure = Measure::formula,
                 .smallest = 0.05,
                 .typical = 3,
                 .largest = 80,
                 .possible = has_imu,
                 .apply =
                     [](FamilyFlight& f, double a, const Shape& k) {
                       f.world.sensors.vibration = a;
                       f.world.sensors.vibration_rotor = k.whole(0, 1, f.vehicle.nominal.rotor_count());
                     },
                 .size = shake});
}

}  // namespace omniflight::proof
