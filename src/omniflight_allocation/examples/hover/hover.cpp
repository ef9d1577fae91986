// What upright hover costs at every tilt of the rotors: least mechanical power [W] and the largest load of a
// rotor (thrust over its limit).
#include <cstdio>
#include <omniflight_allocation/hover_power.hpp>
#include <omniflight_vehicle/vehicle.hpp>

int main(int argc, char** argv) {
  const auto vehicle = omniflight::vehicle::load_vehicle(argc > 1 ? argv[1] : "omnimorph");
  if (!vehicle) {
    std::fprintf(stderr, "%s\n", vehicle.error().text().c_str());
    return 4;
  }
  for (int degrees = 0; degrees <= 60; degrees += 10) {
    const double alpha = degrees * 3.14159265358979 / 180;
    const auto cost = omniflight::allocation::hover_cost(*vehicle, alpha, omniflight::Vec3(0, 0, 1));
    if (!cost) {
      std::fprintf(stderr, "%s\n", cost.error().text().c_str());
      return 4;
    }
    if (cost->possible)
      std::printf("tilt %2d deg: %6.1f W, largest load %.2f\n", degrees, cost->power, cost->largest_load);
    else
      std::printf("tilt %2d deg: upright hover is not possible\n", degrees);
  }
  return 0;
}
