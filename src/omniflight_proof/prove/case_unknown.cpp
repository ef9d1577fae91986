// Mechanisms that no effect library has: what must be called unknown.
#include <algorithm>

#include "case_mechanism_words.hpp"

namespace omniflight::proof {

namespace {

Mechanism law(const char* realisation, Law::Kind kind, double typical, std::vector<std::string> variables,
              std::function<void(Law&, const Shape&)> shape) {
  Mechanism m{.id = "unknown", .stage = "wrench", .realisation = realisation, .level = "L5"};
  m.smallest = typical * 1e-4;
  m.typical = typical;
  m.largest = std::min(1000.0, typical * 1e4);
  m.apply = [kind, shape](FlightSetup& s, double a, const Shape& k) {
    Law l;
    l.kind = kind;
    l.gain = a;
    shape(l, k);
    s.world.laws.push_back(l);
  };
  m.parameters = [](double, const Shape&) { return std::vector<TrueParameter>{}; };
  m.variables = std::move(variables);
  return m;
}

}  // namespace

void unknown_laws(std::vector<Mechanism>& out) {
  out.push_back(law("force across rotor circulation and velocity", Law::Kind::magnus, 1e-3,
                    {"speed", "rotor speed"}, [](Law&, const Shape&) {}));
  out.push_back(law("lift with the square of the speed", Law::Kind::lift, 2, {"speed", "vertical speed"},
                    [](Law& l, const Shape& k) { l.axis = k.direction(0, true); }));
  out.push_back(law("force in one place of the room", Law::Kind::well, 0.5, {"position", "height"},
                    [](Law& l, const Shape& k) {
                      l.axis = k.direction(0);
                      l.center_W =
                          Vec3(k.between(2, -0.15, 0.15), k.between(3, -0.15, 0.15), k.between(4, 0.6, 1.3));
                      l.scale = k.between(5, 0.12, 0.25);
                    }));
  out.push_back(law("force in waves over the room", Law::Kind::corrugation, 0.2, {"position"},
                    [](Law& l, const Shape& k) {
                      l.axis = k.direction(0);
                      l.wave_W = k.direction(2, true);
                      l.scale = k.between(4, 0.2, 0.4);
                    }));
  out.push_back(law("torque that pulls the nose to a direction", Law::Kind::compass, 0.02, {"attitude"},
                    [](Law& l, const Shape& k) { l.axis = k.direction(0, true); }));
  out.push_back(law("a wheel that turns inside", Law::Kind::flywheel, 0.02, {"rate"},
                    [](Law& l, const Shape& k) { l.axis = k.direction(0); }));
  out.push_back(law("force that pulsates", Law::Kind::pulsation, 0.2, {"time"}, [](Law& l, const Shape& k) {
    l.axis = k.direction(0);
    l.scale = k.between(2, 0.6, 2.5);
  }));
  out.push_back(law("sideways force from climbing off the centre", Law::Kind::heave_lock, 10,
                    {"vertical speed", "position"},
                    [](Law& l, const Shape& k) { l.axis = k.direction(0, true); }));
  Mechanism slosh{
      .id = "unknown", .stage = "wrench", .realisation = "mass on springs inside the body", .level = "L5"};
  slosh.smallest = 0.001;
  slosh.typical = 0.1;
  slosh.largest = 0.5;
  slosh.articulated = true;
  slosh.apply = [](FlightSetup& s, double a, const Shape& k) {
    s.world.body.sloshing_mass = a;
    s.world.body.sloshing_frequency = k.between(0, 1.2, 2.5);
    s.world.body.sloshing_damping_ratio = k.between(1, 0.03, 0.1);
  };
  slosh.parameters = [](double, const Shape&) { return std::vector<TrueParameter>{}; };
  slosh.variables = {"acceleration", "time"};
  out.push_back(slosh);
}

}  // namespace omniflight::proof
