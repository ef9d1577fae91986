#include "family_make.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>

#include "family_laboratory.hpp"
#include "family_oracle.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

using Measure = Hidden::Measure;
using Channels = std::array<double, 6>;

struct Strongest {
  double sigma = 0;
  std::size_t channel = 0;
};
Strongest strongest(const Channels& rms, const Channels& noise) {
  Strongest out;
  for (std::size_t c = 0; c < 6; ++c)
    if (const double sigma = noise[c] > 0 ? rms[c] / noise[c] : 0; sigma > out.sigma) out = {sigma, c};
  return out;
}

/// By energy: what the nominal world has as well (the servo's own lag) is no part of the effect.
Channels beyond(const Channels& rms, const Channels& nominal) {
  Channels out{};
  for (std::size_t c = 0; c < 6; ++c)
    out[c] = std::sqrt(std::max(0.0, rms[c] * rms[c] - nominal[c] * nominal[c]));
  return out;
}

struct Measured {
  Channels rms{};
  double sigma = 0;
  std::string channel;
};

Measured measure(const Hidden& h, const FamilyFlight& f, double a, const Shape& shape,
                 const FamilyFlown& flown, const FamilyFlown& nominal, const Channels& noise) {
  Measured out;
  if (h.measure == Measure::formula) {
    const SensorSize size = h.size(f, a, shape, nominal);
    out.rms = size.wrench;
    const Strongest s = strongest(size.wrench, noise);
    out.sigma = size.sigma > 0 ? size.sigma : s.sigma;
    out.channel = size.sigma > 0 ? "formula" : kChannels[s.channel];
    return out;
  }
  out.rms = h.measure == Measure::wrench    ? beyond(flown.wrench, nominal.wrench)
            : h.measure == Measure::command ? beyond(flown.command, nominal.command)
                                            : beyond(flown.control, nominal.control);
  const Strongest s = strongest(out.rms, noise);
  out.sigma = s.sigma;
  out.channel = kChannels[s.channel];
  return out;
}

struct Tuned {
  double amplitude = 0;
  Measured size;
};

/// Turns the amplitude until the effect alone, without turbulence, has the wanted size.
Result<Tuned> tune(const Hidden& h, const Shape& shape, const FamilyFlight& quiet, const FamilyFlown& nominal,
                   const Channels& noise, double target) {
  double a = h.typical;
  Tuned best;
  double miss = 1e300;
  std::string why = "it does nothing in this flight";
  for (int round = 0; round < (h.measure == Measure::formula ? 20 : 6); ++round) {
    FamilyFlight trial = quiet;
    h.apply(trial, a, shape);
    Measured size;
    if (h.measure == Measure::formula) {
      size = measure(h, trial, a, shape, nominal, nominal, noise);
    } else {
      auto flown = fly(trial);
      if (!flown) {
        why = flown.error().text();
        if (a <= 2 * h.smallest) break;
        a = std::max(h.smallest, 0.35 * a);
        continue;
      }
      size = measure(h, trial, a, shape, *flown, nominal, noise);
    }
    const double off = std::abs(std::log(std::max(1e-9, size.sigma / target)));
    if (off < miss) {
      miss = off;
      best = {a, size};
    }
    if (off < 0.08) break;
    const double next =
        std::clamp(a * std::clamp(target / std::max(1e-9, size.sigma), 0.02, 20.0), h.smallest, h.largest);
    if (next == a) break;
    a = next;
  }
  if (best.amplitude == 0)
    return fail(ErrorCode::incomplete, "no size of it can be flown: " + why, h.realisation);
  return best;
}

/// What must not be there while effects are measured: turbulence, noise, faults.
FamilyFlight without_noise(const FamilyFlight& f) {
  FamilyFlight quiet = f;
  quiet.record = false;
  quiet.world.turbulence.reset();
  quiet.world.sensors = {};
  return quiet;
}

constexpr double kCalmer = 0.7;         ///< vigour of a flight that was lost
constexpr double kTooSmall = 0.15;      ///< sigma; nobody can be asked to find it
constexpr double kSmallestShare = 0.5;  ///< of the wanted size; smaller ones count as what they are

struct Attempt {
  const FamilyPlan& plan;
  const std::string& salt;
  Box box;
  const LoaderKnows& loader;
};

Result<MadeFamilyCase> attempt(const Attempt& at, double vigour) {
  const FamilyPlan& plan = at.plan;
  const Coordinates& where = plan.where;
  BoxRandom random(draw(at.salt, plan.id), at.box);
  auto vehicle = draw_vehicle(where, random);
  if (!vehicle) return Failure(vehicle.error());
  Laboratory lab = draw_laboratory(where, *vehicle, plan.decoy, vigour, random);
  MadeFamilyCase out;
  FamilyCase& c = out.truth;
  c.where = where;
  c.unseen = plan.unseen;
  Truth& t = c.truth;
  t.id = plan.id;
  t.kind = plan.kind;
  t.level = to_string(plan.kind);
  t.flight = where.manoeuvre;
  t.decoy = plan.decoy;
  t.seed = lab.flight.seed;
  t.magnitude = plan.sigma;
  t.present = lab.present;
  const Turbulence& turbulence = lab.told_turbulence;
  for (std::size_t k = 0; k < 6; ++k) {
    c.turbulence[k] = k < 3 ? turbulence.force_rms : turbulence.torque_rms;
    c.sensor[k] = lab.sensor_noise[k];
    t.noise[k] = std::hypot(c.turbulence[k], c.sensor[k]);
  }
  const FamilyFlight quiet = without_noise(lab.flight);
  auto nominal = fly(quiet);
  if (!nominal) return Failure(nominal.error());
  BoxRandom calibration(draw(at.salt, plan.id + " calibration"), at.box);
  leave_uncalibrated(lab, calibration);
  FamilyFlight together = quiet;
  together.series = true;
  double smallest = 1e300;
  for (const std::size_t k : plan.hidden) {
    const Hidden& h = hidden_effects()[k];
    Random own = draw(at.salt, plan.id + " shape " + std::to_string(k));
    const Shape shape = draw_shape(own, at.box == Box::sealed);
    auto tuned = tune(h, shape, quiet, *nominal, t.noise, plan.sigma);
    if (!tuned) return Failure(tuned.error());
    h.apply(lab.flight, tuned->amplitude, shape);
    h.apply(together, tuned->amplitude, shape);
    for (const std::string& id : h.along) t.present.push_back(id);
    smallest = std::min(smallest, tuned->size.sigma);
    t.effects.push_back({h.id, h.stage, fmt::format("{}, amplitude {:.3g}", h.realisation, tuned->amplitude),
                         tuned->size.sigma,
                         h.parameters ? h.parameters(lab.flight, tuned->amplitude, shape) : Parameters{},
                         h.variables});
    c.sizes.push_back({tuned->size.rms, tuned->size.sigma, tuned->size.channel, h.law});
  }
  if (!plan.hidden.empty() && smallest < kTooSmall)
    return fail(ErrorCode::impossible, fmt::format("is of {:.2g} sigma at the most in this flight", smallest),
                plan.id);
  if (!plan.hidden.empty() && smallest < kSmallestShare * plan.sigma) t.magnitude = smallest;
  auto flown = fly(lab.flight);
  if (!flown) return Failure(flown.error());
  if (!plan.hidden.empty()) {
    auto alone = fly(together);
    if (!alone) return Failure(alone.error());
    t.wrench = beyond(alone->wrench, nominal->wrench);
    for (std::size_t k = 0; k < 6; ++k)
      t.wrench_variance[k] = std::max(0.0, t.wrench[k] * t.wrench[k] - alone->mean[k] * alone->mean[k]);
    c.oracle = ask_oracle(plan, lab, c.turbulence, *alone);
  }
  const std::string text = recording::to_csv(flown->recording);
  Random padding = draw(at.salt, plan.id + " padding");
  constexpr std::size_t block = std::size_t{1} << 18;  // sizes tell the length of the flight and little else
  for (std::size_t size = block * (1 + text.size() / (8 * block));; size += block) {
    auto gz = gzip_of_size(text, size, padding);
    if (!gz && size < text.size() + 4 * block) continue;
    if (!gz) return Failure(gz.error());
    out.recording = std::move(*gz);
    break;
  }
  out.vehicle = vehicle_yaml(*vehicle, at.loader.servo);
  if (!at.loader.servo && where.tilt == "moves") t.present.emplace_back("tilt_servo_lag");
  out.told = told_yaml(lab, where);
  return out;
}

}  // namespace

LoaderKnows what_the_loader_knows() {
  LoaderKnows out;
  Coordinates where;
  where.vehicle = "omnimorph";
  BoxRandom random(Random(1), Box::tuning);
  auto vehicle = draw_vehicle(where, random);
  char name[] = "/tmp/omniflight-vehicle-XXXXXX";
  const int fd = vehicle ? mkstemp(name) : -1;
  if (fd < 0) return out;
  close(fd);
  if (files::write_file_atomic(name, vehicle_yaml(*vehicle, true)))
    out.servo = static_cast<bool>(vehicle::load_vehicle(name));
  unlink(name);
  return out;
}

Result<MadeFamilyCase> make_family_case(const FamilyPlan& plan, const std::string& salt, Box box,
                                        const LoaderKnows& loader) {
  const Attempt at{plan, salt, box, loader};
  Error last;
  for (double vigour = 1; vigour > 0.2; vigour *= kCalmer) {
    auto made = attempt(at, vigour);
    if (made || made.error().code != ErrorCode::incomplete) return made;
    last = made.error();
  }
  last.where = plan.id + ", " + plan.where.vehicle + ", " + plan.where.manoeuvre + ", " +
               plan.where.controller + ": " + last.where;
  return Failure(last);
}

}  // namespace omniflight::proof
