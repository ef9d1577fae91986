// Mechanisms that no effect library has: what must be called unknown, by its variables.
#include "hidden.hpp"

namespace omniflight::proof {
namespace {

using Shaped = std::function<void(FamilyFlight&, Law&, double, const Shape&)>;

Hidden law(const char* realisation, Law::Kind kind, double typical, double largest,
           std::vector<std::string> variables, bool unseen, Shaped shape) {
  Hidden h{.id = "unknown", .stage = "wrench", .realisation = realisation};
  h.unseen = unseen;
  h.combines = false;
  h.smallest = typical * 1e-3;
  h.typical = typical;
  h.largest = largest;
  h.apply = [kind, shape](FamilyFlight& f, double a, const Shape& k) {
    Law l;
    l.kind = kind;
    l.gain = a * f.vehicle.weight();
    shape(f, l, a, k);
    f.world.laws.push_back(l);
  };
  h.variables = std::move(variables);
  h.possible = [](const FamilyVehicle&, const Coordinates& c) { return c.manoeuvre != "T1"; };
  return h;
}

}  // namespace

void hide_unknown(std::vector<Hidden>& out) {
  out.push_back(law("lift with the square of the speed", Law::Kind::lift, 0.05, 3,
                    {"speed", "vertical speed"}, false,
                    [](FamilyFlight&, Law& l, double, const Shape& k) { l.axis = k.direction(0, true); }));
  out.push_back(law("force in one place of the room", Law::Kind::well, 0.05, 0.4, {"position", "height"},
                    false, [](FamilyFlight& f, Law& l, double, const Shape& k) {
                      l.axis = k.direction(0);
                      const double r = 0.4 * f.vehicle.reach;
                      l.center_W = Vec3(k.between(2, -r, r), k.between(3, -r, r), f.path.position[2].start);
                      l.scale = k.between(5, 0.25, 0.45) * f.vehicle.reach;
                    }));
  out.push_back(law("torque that pulls the nose to a direction", Law::Kind::compass, 0.01, 0.2, {"attitude"},
                    false, [](FamilyFlight& f, Law& l, double, const Shape& k) {
                      l.axis = k.direction(0, true);
                      l.gain *= f.vehicle.arm();
                    }));
  out.push_back(law("force that pulsates", Law::Kind::pulsation, 0.03, 0.3, {"time"}, false,
                    [](FamilyFlight&, Law& l, double, const Shape& k) {
                      l.axis = k.direction(0);
                      l.scale = k.between(2, 0.6, 2.5);
                    }));
  out.push_back(law("force across rotor circulation and velocity", Law::Kind::crosswise, 0.02, 0.3,
                    {"speed", "rotor speed"}, false, [](FamilyFlight&, Law&, double, const Shape&) {}));
  // only a sealed run hides these
  out.push_back(law("force in waves over the room", Law::Kind::corrugation, 0.03, 0.3, {"position"}, true,
                    [](FamilyFlight& f, Law& l, double, const Shape& k) {
                      l.axis = k.direction(0);
                      l.wave_W = k.direction(2, true);
                      l.scale = k.between(4, 0.5, 0.9) * f.vehicle.reach;
                    }));
  out.push_back(law("a wheel that turns inside", Law::Kind::flywheel, 0.005, 0.1, {"rate"}, true,
                    [](FamilyFlight& f, Law& l, double, const Shape& k) {
                      l.axis = k.direction(0);
                      l.gain *= f.vehicle.arm();
                    }));
  out.push_back(law("sideways force from climbing off the centre", Law::Kind::heave_lock, 0.2, 5,
                    {"vertical speed", "position"}, true,
                    [](FamilyFlight&, Law& l, double, const Shape& k) { l.axis = k.direction(0, true); }));
  out.push_back(law("torque across the rate that grows with rotor speeds", Law::Kind::gyration, 1e-6, 1e-3,
                    {"rate", "rotor speed"}, true, [](FamilyFlight& f, Law& l, double, const Shape& k) {
                      l.axis = k.direction(0, true);
                      l.gain *= f.vehicle.arm();
                    }));
  Hidden slosh{.id = "unknown", .stage = "wrench", .realisation = "liquid that sloshes in a tank"};
  slosh.combines = false;
  slosh.slow = true;
  slosh.smallest = 0.003;
  slosh.typical = 0.1;
  slosh.largest = 0.4;
  slosh.apply = [](FamilyFlight& f, double a, const Shape& k) {
    f.world.body.sloshing_mass = a * mass(f);
    f.world.body.sloshing_frequency = k.between(0, 1.2, 2.5);
    f.world.body.sloshing_damping_ratio = k.between(1, 0.03, 0.1);
  };
  slosh.variables = {"acceleration", "time"};
  out.push_back(slosh);
}

}  // namespace omniflight::proof
