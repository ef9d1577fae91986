// What the world of the proof is made of. Every member is a mechanism (a chain of links, a jet, a servo with
// backlash), not a law of the effect library, and nothing here shares code with it. A default World is the
// nominal vehicle: a rigid body with rotors whose thrust goes with the square of a first-order speed.
// SI units, radians; W: world, z up; B: body axes, origin of the vehicle file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "omniflight_core/frames.hpp"
#include "omniflight_core/result.hpp"
#include "omniflight_files/yaml.hpp"

namespace omniflight::proof {

enum class Integrator { euler, implicit };  ///< of MuJoCo; euler is semi-implicit, implicit in joint damping

// --- The body
// ------------------------------------------------------------------------------------------------
struct BodyChange {
  double payload = 0;                  ///< kg, a ball fixed to the body
  Vec3 payload_p_B = Vec3::Zero();     ///< m, its centre
  double payload_radius = 0.02;        ///< m
  Vec3 com_shift_B = Vec3::Zero();     ///< m, added to the centre of mass
  Vec3 inertia_scale = Vec3::Ones();   ///< factors on the moments of inertia about body axes
  Vec3 inertia_turn_B = Vec3::Zero();  ///< rad, rotation vector that turns the axes of inertia
  double sloshing_mass = 0;  ///< kg inside the body, on springs in all three directions; taken from its mass
  double sloshing_frequency = 3;  ///< Hz
  double sloshing_damping_ratio = 0.1;
};

/// Every rotor on a pod that is hinged to the core and held by a spring.
struct FlexibleArms {
  double pod_mass = 0.03;  ///< kg each, taken from the vehicle's mass and inertia
  double frequency = 20;   ///< Hz, of a pod on a fixed core
  double damping_ratio = 0.05;
  double root = 0.4;  ///< where the hinge is, as a share of the way from the origin to the rotor
};

// --- Actuation
// -----------------------------------------------------------------------------------------------
/// What one rotor (or all of them) does differently. Changes apply in their order.
struct RotorChange {
  int rotor = 0;  ///< 1...n; 0 = all
  double thrust_scale = 1;
  double reverse_scale = 1;  ///< on thrust while it turns backwards
  double drag_torque_scale = 1;
  double exponent = 2;        ///< thrust ~ speed^exponent, same thrust as nominal at half of the full speed
  double time_constant = -1;  ///< s; < 0: as in the vehicle file
  double slowing_factor = 1;  ///< slows down with this times the time constant
  double delay = 0;           ///< s, of the command
  double dead_speed = 0;      ///< rad/s, commands below it stop the rotor
  double max_speed = 0;       ///< rad/s, 0: as in the vehicle file
  double quantum = 0;         ///< rad/s, commands are rounded to multiples
  double inertia = 0;         ///< kg m^2, of the spinning parts about their axis
  Vec3 axis_tilt_B = Vec3::Zero();           ///< rad, rotation vector of the axis
  Vec3 shift_B = Vec3::Zero();               ///< m, of the hub
  double fails_from = -1, fails_until = -1;  ///< s; stopped in between; < 0: never
  double linear_share = 0;     ///< of the thrust at half of the full speed that goes with the speed itself
  double drag_exponent = 0;    ///< torque per thrust ~ speed^drag_exponent, nominal at half of the full speed
  Vec3 lean_B = Vec3::Zero();  ///< rad/N, rotation vector of the axis per thrust: a mount that bends
  double slew = 0;             ///< rad/s^2, fastest change of speed; 0: none
  double hold = 0;             ///< s, commands are taken over only this often
  double restart = 0;          ///< s, a rotor that stopped or reverses stands this long
  double thrust_lag = 0;       ///< s, time that the air of the rotor takes to follow a change of thrust
  double thrust_lead = -1;     ///< share of a sudden change by which thrust overshoots; -1: it comes late
};

/// Hidden, behind what the servo reports; lag and play that the vehicle file tells are in the report.
struct TiltChange {
  double offset = 0;         ///< rad, true less reported
  double time_constant = 0;  ///< s, servo lag on top of the rate limit
  double backlash = 0;       ///< rad, play of the linkage
  double rate_scale = 1;     ///< on the rate limit of the servo
  double loss = 0;           ///< share of thrust that is lost at loss_center (or at tilt 0 without a width)
  double loss_center = 0,
         loss_width = 0;  ///< rad; loss exp(-((alpha - center) / width)^2), or linear to 60 deg
};

/// The speed controllers reach less when the battery is low: speed = command * (voltage /
/// nominal)^sensitivity.
struct BatterySag {
  double nominal = 16.8;         ///< V, full and without load
  double resistance = 0.03;      ///< ohm
  double drop = 2e-4;            ///< V per J drawn
  double polarisation = 0.02;    ///< ohm, of the slow part
  double polarisation_time = 8;  ///< s
  double sensitivity = 0.6;
  double efficiency = 0.7;  ///< mechanical per electrical power
};

// --- Air
// -----------------------------------------------------------------------------------------------------
/// Rotors by blade-element momentum theory, matched to the vehicle file's thrust and torque in still air.
struct Blades {
  double solidity_slope = 0.6;  ///< solidity times lift slope, 1/rad
  bool edgewise = true;         ///< translational lift and in-plane (H) force
  double flapping = 0;          ///< 0...1, share of the first-harmonic tilt of the thrust
  double hub_stiffness = 0;     ///< N m per rad of that tilt, pitching moment at the hub
  double inflow_time = 0;       ///< s, lag of the induced velocity
};
/// Every rotor's slipstream as a contracting, then spreading jet that the others work in.
struct Jets {
  double strength = 1;   ///< on the induced velocity; 1 is momentum theory
  double spread = 0.06;  ///< growth of the radius per distance
  double body_drag = 0;  ///< m^2, drag area of the core in the jets
};
/// Image of the slipstream in a plane: floor and ceiling change the induced velocity.
struct Planes {
  double floor = 0;      ///< strength; 1: potential source of Cheeseman and Bennett
  double ceiling = 0;    ///< strength
  double ceiling_z = 3;  ///< m
};
/// Another vehicle that hovers or passes above; only its slipstream is felt.
struct Neighbour {
  Vec3 p_W = Vec3(0, 0, 3);          ///< m, at time 0
  Vec3 v_W = Vec3::Zero();           ///< m/s
  double thrust = 10;                ///< N
  double radius = 0.2;               ///< m, of an equal disc
  double appears = 0, leaves = 1e9;  ///< s
};
struct Airframe {
  Vec3 drag_area_B = Vec3::Zero();  ///< m^2, Cd times area of plates across x, y, z
  double round_area = 0;            ///< m^2, Cd times area of a sphere
  Vec3 center_B = Vec3::Zero();     ///< m, where the drag acts
  double rotation_damping = 0;      ///< N m s^2, torque = -c |w| w
};
/// Forces of rotors in moving air by coefficients instead of blades.
struct RotorAir {
  double drag = 0;      ///< kg/rad, force -drag |speed| v across the axis
  double flapping = 0;  ///< kg m/rad, torque flapping |speed| v x axis: forward flight lifts the nose
  double descent_loss = 0, descent_center = 1,
         descent_width = 0.35;  ///< of thrust, over descent / hover inflow
};
struct Gust {
  double start = 0, duration = 1;  ///< s, a 1-cosine
  Vec3 velocity_W = Vec3::Zero();  ///< m/s
};
struct Wind {
  Vec3 velocity_W = Vec3::Zero();  ///< m/s at the reference height
  double reference_height = 1;     ///< m above the floor
  double profile_exponent = 0;     ///< speed ~ (height / reference)^exponent
  double gust_rms = 0;             ///< m/s an axis, first-order shaped turbulence
  double gust_length = 1;          ///< m; correlation time = length / max(speed, 0.5 m/s)
  std::vector<Gust> gusts = {};
};
/// Random wrench nobody models: what remains in every flight.
struct Turbulence {
  enum class Kind {
    ou,      ///< first-order
    dryden,  ///< second-order, of Dryden's transverse spectrum (MIL-F-8785C)
    heavy,  ///< first-order, its strength wanders log-normally: tails as of Student's t with about 5 freedoms
    bursts  ///< calm most of the time, three times as strong for a sixth of it
  } kind = Kind::ou;
  double force_rms = 0;           ///< N an axis, world
  double torque_rms = 0;          ///< N m an axis, body
  double correlation_time = 0.3;  ///< s
};

// --- Tether, rope, contact
// -----------------------------------------------------------------------------------
/// Links on ball joints that hang from the vehicle, with floor contact and friction.
struct Cable {
  double linear_density = 0.15;  ///< kg/m
  double length = 1.44;          ///< m
  int links = 20;
  double diameter = 0.008;                ///< m
  Vec3 attachment_B = Vec3(0, 0, -0.12);  ///< m
  double initial_bend = 0.06;    ///< rad, from link to link: a straight chain would stand like a column
  double bending_stiffness = 0;  ///< N m^2, EI
  double damping = 2e-4;         ///< N m s/rad, every joint
  double floor_friction = 0.5;
  double drag_coefficient = 0;  ///< cross-flow drag of the links, on diameter
};
/// The same between the vehicle and a point of the ceiling.
struct OverheadRope {
  double linear_density = 0.03;  ///< kg/m
  double length = 2.6;           ///< m
  int links = 20;
  Vec3 anchor_W = Vec3(0, 0, 3);         ///< m
  Vec3 attachment_B = Vec3(0, 0, 0.12);  ///< m
  double damping = 5e-4;                 ///< N m s/rad, every joint
};
struct SlungBall {
  double mass = 0.1;                      ///< kg
  double length = 0.6;                    ///< m, from the attachment to the centre
  double radius = 0.03;                   ///< m
  Vec3 attachment_B = Vec3(0, 0, -0.12);  ///< m
  double damping = 1e-3;                  ///< N m s/rad
  int links = 1;                          ///< 1: a rod; more: a rope of rods on ball joints
};
/// Spring between the vehicle and a point of the world.
struct Spring {
  Vec3 anchor_W = Vec3::Zero();
  Vec3 attachment_B = Vec3::Zero();
  double stiffness = 0;    ///< N/m
  double damping = 0;      ///< N s/m
  double rest_length = 0;  ///< m
  bool rope = true;        ///< pulls only
  double hardening = 0;    ///< 1/m, force = stiffness x (1 + hardening x)
};
/// Constant-force spring motor far away: the same pull wherever the vehicle is.
struct Pull {
  Vec3 force_W = Vec3::Zero();  ///< N
  Vec3 attachment_B = Vec3::Zero();
  double from = 0;                ///< s, begins to pull
  double until = 1e9, fades = 0;  ///< s, ends, and fades out over so long before
};

// --- What no library has
// -------------------------------------------------------------------------------------
struct Law {
  enum class Kind {
    magnus,         ///< F_B = gain * (sum of rotor speeds along their axes) x v_B       [N s^2/m]
    lift,           ///< F_W = gain * |v|^2 * axis_B across the velocity                  [N s^2/m^2]
    well,           ///< F_W = gain * axis_W * exp(-|p - center|^2 / (2 scale^2))         [N]
    corrugation,    ///< F_W = gain * axis_W * sin(2 pi (p - center).wave_W / scale)      [N]
    compass,        ///< tau_B = gain * x_B x (R^T axis_W): pulls the nose to a direction  [N m]
    flywheel,       ///< tau_B = -w x (gain * axis_B)                                     [N m s]
    pulsation,      ///< F_B = gain * axis_B * sin(2 pi scale t)                          [N]
    heave_lock,     ///< F_W = -gain * v_z |p_xy - center_xy| axis_W: couples height and side   [N s/m^2]
    cushion,        ///< F_W = gain * axis_W * exp(-(p - center).axis_W / scale)          [N]
    friction,       ///< F_W = -gain * v/|v| tanh(|v| / scale)                            [N]
    rail,           ///< F_W = -gain * axis_W tanh(v.axis_W / scale)                      [N]
    torsion,        ///< tau_W = -gain * (yaw - center_x) * z_W                           [N m/rad]
    torsion_cubic,  ///< the same with (yaw + yaw^3 / scale^2)
    crosswise,      ///< F_W = gain * z_W x v: across the velocity                      [N s/m]
    gyration        ///< tau_B = gain * sum of |rotor speeds| * axis_B x w               [N m s^2]
  };
  Kind kind = Kind::well;
  double gain = 0;
  Vec3 axis = Vec3::UnitZ();
  Vec3 center_W = Vec3::Zero();  ///< m
  Vec3 wave_W = Vec3::UnitX();   ///< unit, direction in which a corrugation repeats
  double scale = 0.3;            ///< m, or Hz for a pulsation
};

// --- Measuring
// -----------------------------------------------------------------------------------------------
/// A sensor that shows an old value, or a share of the true one, for a while.
struct SensorFault {
  enum class Sensor { imu, mocap, rotor_speed, battery } sensor = Sensor::mocap;
  int rotor = 0;                 ///< of rotor_speed: 1...n, 0 = all
  double from = 0, until = 1e9;  ///< s
  double scale = 1;              ///< of rotor_speed, or of the battery voltage
  bool frozen = false;           ///< repeats the last value
  bool silent = false;           ///< sends nothing
};
/// On top of the sensor file: errors the model of the sensors does not know.
struct SensorChange {
  Vec3 accelerometer_bias = Vec3::Zero();      ///< m/s^2
  Vec3 accelerometer_scale = Vec3::Zero();     ///< relative error
  Vec3 gyro_bias = Vec3::Zero();               ///< rad/s
  Vec3 gyro_scale = Vec3::Zero();              ///< relative error
  Vec3 imu_p_B = Vec3::Zero();                 ///< m, lever arm
  double imu_low_pass = 0;                     ///< Hz, first order twice; 0: none
  double vibration = 0;                        ///< m/s^2 at full speed of a rotor, at its frequency
  int vibration_rotor = 0;                     ///< 1...n, which; 0: all
  Vec3 mocap_turn_B = Vec3::Zero();            ///< rad, of the marker frame
  double pose_repeat = 0;                      ///< probability that a pose repeats the last one
  double outlier_share = 0, outlier_size = 6;  ///< probability and size (of the RMS) of wild samples
  Vec3 mocap_rotation_W = Vec3::Zero();        ///< rad, of its world
  Vec3 mocap_offset_B = Vec3::Zero();          ///< m, of the marker frame
  double mocap_extra_latency = 0;              ///< s, that the stamps do not tell
  double board_clock_skew = 0;                 ///< 1, stamps of IMU, rotors and battery run fast by this
  double board_clock_offset = 0;               ///< s
  double noise_correlation_time = 0;           ///< s; > 0 colours all noise, same rms
  double rotor_dropout = 0, imu_dropout = 0;   ///< probability of a missing sample
  std::vector<SensorFault> faults = {};
};

struct World {
  std::string name = "nominal";
  double timestep = 0.001;  ///< s, of MuJoCo
  Integrator integrator = Integrator::euler;
  double floor_z = 0;        ///< m; what hangs from the vehicle lies on it
  double air_density = 1.2;  ///< kg/m^3
  double settle = 3;         ///< s that ropes and loads get to come to rest before time 0
  BodyChange body;
  std::optional<FlexibleArms> flexible_arms;
  std::vector<RotorChange> rotors;
  TiltChange tilt;
  std::optional<BatterySag> battery;
  std::optional<Blades> blades;
  std::optional<Jets> jets;
  std::optional<Planes> planes;
  std::vector<Neighbour> neighbours;
  std::optional<Airframe> airframe;
  std::optional<RotorAir> rotor_air;
  std::optional<Wind> wind;
  std::optional<Turbulence> turbulence;
  std::optional<Cable> cable;
  std::optional<OverheadRope> overhead_rope;
  std::optional<SlungBall> slung_ball;
  std::vector<Spring> springs;
  std::vector<Pull> pulls;
  std::vector<Law> laws;
  SensorChange sensors;

  /// True when something hangs from, or moves in, the vehicle and has to come to rest first.
  bool articulated() const {
    return cable || overhead_rope || slung_ball || flexible_arms || body.sloshing_mass > 0;
  }
};

/// Reads a world (schema omniflight.proof_world/1; keys and units in the README). Unknown keys, numbers that
/// are not finite or out of range are refused with file, line, field and unit.
Result<World> load_world(const std::filesystem::path& path);
Result<World> read_world(files::YamlReader yaml);

/// What the reader checks, for worlds made in code. The error names the field and its unit.
Status validate(const World& world);

}  // namespace omniflight::proof
