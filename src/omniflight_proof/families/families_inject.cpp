// omniflight_proof_inject: hides effects in recordings of real flights, seals the truth.
//   omniflight_proof_inject --real DIR --vehicle V --out DIR --seal DIR [--cases N] [--nulls N]
// The same folders as omniflight_proof_families. Flights that nothing is added to are the nominal ones.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "family_publish.hpp"
#include "injection.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string real, vehicle, out, seal, salt;
  int cases = 20, nulls = 10;
  long seed = -1;
  bool tuning = false, quiet = false;
};

/// Physics that a real vehicle has and its file has not: naming it is no alarm.
const std::vector<std::string> kReal{"rotor_drag", "blade_flapping", "rotor_inertia"};
constexpr double kSizes[] = {0.3, 1, 3};
constexpr int kRedraws = 30;
constexpr double kMostLimited = 0.02;  ///< share of samples with a rotor at its limit

Result<std::vector<RealFlight>> load_flights(const Options& o, const vehicle::Vehicle& vehicle) {
  std::vector<fs::path> files;
  std::error_code ec;
  for (fs::recursive_directory_iterator it(o.real, ec), end; !ec && it != end; it.increment(ec))
    if (it->is_regular_file(ec)) files.push_back(it->path());
  if (ec) return bad_input("cannot be listed: " + ec.message(), o.real, "Give a folder of recordings");
  std::sort(files.begin(), files.end());
  std::vector<RealFlight> out;
  std::string why = "it has no files";
  for (const fs::path& file : files) {
    auto recording = recording::load(file);
    auto flight = recording ? RealFlight::create(std::move(*recording), vehicle)
                            : Result<RealFlight>(Failure(recording.error()));
    if (flight)
      out.push_back(std::move(*flight));
    else
      why = flight.error().text();
    if (!flight && !o.quiet)
      std::cerr << file.filename().string() << " is left out: " << flight.error().text() << "\n";
  }
  if (out.empty()) return bad_input("has no flight that can be used (the last: " + why + ")", o.real);
  return out;
}

struct Sized {
  Injected injected;
  double amplitude = 0;
};

/// Turns the amplitude to the wanted size within what the rotors can do.
Sized turn(const RealFlight& f, const Injectable& what, const Shape& shape, double target) {
  Sized best;
  double a = what.typical;
  for (int k = 0; k < 6; ++k) {
    Sized now{inject(f, what, a, shape), a};
    const bool possible = now.injected.limited <= kMostLimited;
    if (possible && std::abs(std::log(now.injected.sigma / target)) <
                        std::abs(std::log(std::max(1e-9, best.injected.sigma) / target)))
      best = now;
    if (possible && std::abs(now.injected.sigma / target - 1) < 0.05) break;
    const double next =
        possible ? a * std::clamp(target / std::max(1e-9, now.injected.sigma), 0.05, 20.0) : 0.6 * a;
    a = std::clamp(next, what.smallest, what.largest);
  }
  return best;
}

FamilyCase truth_of(const Options& o, const RealFlight& f, const std::string& id) {
  FamilyCase c;
  c.truth.id = id;
  c.truth.flight = "real";
  c.truth.level = "real";
  c.truth.present = kReal;
  c.truth.noise = f.noise();
  c.sensor = f.noise();
  c.where.vehicle = "real " + fs::path(o.vehicle).stem().string();
  c.where.controller = "real";
  c.where.told_gains = "not told";
  c.where.start = "rest";
  c.where.manoeuvre = "real";
  c.where.signals = "imu+speed";
  c.where.reference = f.recording().find("ref_position") != nullptr;
  c.where.turbulence = c.where.noise = "real";
  c.where.calibration = "not told";
  c.where.length = f.recording().duration_s;
  c.where.tilt = "none";
  return c;
}

Status write_case(const Options& o, const std::string& id, const recording::Recording& recording,
                  const std::string& vehicle, Random& padding) {
  const fs::path folder = fs::path(o.out) / "cases" / id;
  std::error_code ec;
  fs::create_directories(folder, ec);
  const std::string text = recording::to_csv(recording);
  constexpr std::size_t block = std::size_t{1} << 18;
  for (std::size_t size = block * (1 + text.size() / (8 * block));; size += block) {
    auto gz = gzip_of_size(text, size, padding);
    if (!gz && size < text.size() + 4 * block) continue;
    if (!gz) return Failure(gz.error());
    if (auto ok = write_neutral(folder / "flight.csv.gz", *gz); !ok) return ok;
    break;
  }
  if (auto ok = write_neutral(folder / "vehicle.yaml", vehicle); !ok) return ok;
  return write_neutral(folder / "told.yaml", "environment: {air_density_kgpm3: 1.2}\n");
}

Result<int> run(Options& o) {
  if (o.tuning != (o.seed >= 0))
    return bad_input(o.tuning ? "needs a --seed" : "is for --tuning only; a sealed run draws its own salt",
                     "--seed", "For instance --tuning --seed 1");
  auto vehicle = vehicle::load_vehicle(o.vehicle);
  if (!vehicle) return Failure(vehicle.error());
  if (vehicle->tilt.kind != vehicle::TiltKind::none)
    return bad_input("tilts its rotors; forces along body z are injected into multirotors with fixed ones",
                     "--vehicle");
  auto yaml = files::read_file(vehicle->file, files::kMegabyte);
  if (!yaml) return Failure(yaml.error());
  if (auto ok = make_private_folder(o.seal); !ok) return Failure(ok.error());
  const fs::path commitment = fs::path(o.out) / "commitment.json";
  if (!fs::exists(commitment)) {
    auto flights = load_flights(o, *vehicle);
    if (!flights) return Failure(flights.error());
    if (o.tuning) {
      o.salt = fmt::format("tuning of injections, {}", o.seed);
    } else if (o.salt.empty()) {
      auto salt = fresh_salt();
      if (!salt) return Failure(salt.error());
      o.salt = *salt;
    }
    Random random = draw(o.salt, "injections");
    std::vector<std::size_t> usable;
    for (std::size_t k = 0; k < injectables().size(); ++k)
      if (!o.tuning || !injectables()[k].unseen) usable.push_back(k);
    std::vector<int> order;  // -1: nominal
    for (int k = 0; k < o.cases; ++k) order.push_back(k);
    order.insert(order.end(), static_cast<std::size_t>(o.nulls), -1);
    for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[random.next() % k]);
    FamilySeal seal{o.salt, o.tuning ? "tuning" : "sealed", {}, {}};
    Progress progress("injecting", static_cast<double>(order.size()), "cases", o.quiet);
    for (std::size_t k = 0; k < order.size(); ++k) {
      if (interrupted())
        return fail(ErrorCode::incomplete, "stopped", "", "Begin again with another --out and --seal");
      const std::string id = fmt::format("case-{:04}", k + 1);
      std::size_t which = random.next() % flights->size();
      const Injectable* what = nullptr;
      Sized sized;
      Shape shape;
      for (int tries = 0; order[k] >= 0 && sized.amplitude == 0; ++tries) {
        if (tries == kRedraws)
          return fail(ErrorCode::incomplete,
                      "leaves the rotors no room in any of the flights that were tried", id,
                      "Give flights with less load");
        which = random.next() % flights->size();
        what = &injectables()[usable[static_cast<std::size_t>(order[k] + tries) % usable.size()]];
        shape = draw_shape(random, !o.tuning);
        sized = turn((*flights)[which], *what, shape, kSizes[random.next() % 3]);
      }
      const RealFlight& flight = (*flights)[which];
      FamilyCase c = truth_of(o, flight, id);
      recording::Recording flown = flight.recording();
      if (what) {
        c.truth.kind = what->id == "unknown" ? Kind::unknown : Kind::single;
        c.truth.magnitude = sized.injected.sigma;
        c.truth.effects.push_back({what->id, "wrench",
                                   fmt::format("{}, amplitude {:.3g}", what->realisation, sized.amplitude),
                                   sized.injected.sigma,
                                   what->parameters ? what->parameters(flight, sized.amplitude, shape)
                                                    : std::vector<TrueParameter>{},
                                   what->variables});
        c.truth.wrench = sized.injected.rms;
        c.sizes.push_back({sized.injected.rms, sized.injected.sigma, sized.injected.channel, what->law});
        if (what->unseen) c.unseen.emplace_back("mechanism");
        flown = std::move(sized.injected.recording);
      }
      if (auto ok = write_case(o, id, flown, *yaml, random); !ok) return Failure(ok.error());
      seal.cases.push_back(std::move(c));
      progress.update(static_cast<double>(k + 1));
    }
    progress.finish();
    if (auto ok = commit_family_run(o.out, o.seal, std::move(seal)); !ok) return Failure(ok.error());
  }
  auto text = files::read_file(commitment, files::kMegabyte);
  if (!text) return Failure(text.error());
  std::cout << *text << std::flush;
  return 0;
}

}  // namespace
}  // namespace omniflight::proof

int main(int argc, char** argv) {
  using namespace omniflight;
  CLI::App app(
      "Hides effects in recordings of real flights: forces along body z and torques, through the rotor "
      "speeds that would "
      "have held the same motion.\nExample: omniflight_proof_inject --real logs --vehicle "
      "crazyflie_brushless --out run --seal run.seal");
  proof::Options o;
  app.add_option("--real", o.real, "Folder of recordings (searched through)")->required();
  app.add_option("--vehicle", o.vehicle, "That flew")->required();
  app.add_option("--out", o.out, "Folder that an analysis sees")->required();
  app.add_option("--seal", o.seal, "Folder that it must not see (mode 700)")->required();
  app.add_option("--cases", o.cases, "With an injected effect")->check(CLI::Range(0, 100000));
  app.add_option("--nulls", o.nulls, "As they were flown")->check(CLI::Range(0, 100000));
  app.add_flag("--tuning", o.tuning, "Draw from the tuning boxes");
  app.add_option("--seed", o.seed, "Of a tuning run")->check(CLI::Range(0L, 1000000000L));
  app.add_option("--salt", o.salt, "For tests only; a sealed run draws its own");
  app.add_flag("--quiet", o.quiet, "No progress");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(ErrorCode::bad_input);
  }
  install_interrupt_handler();
  const auto result = proof::run(o);
  if (result) return *result;
  std::cerr << "omniflight_proof_inject: " << result.error().text() << "\n";
  return static_cast<int>(result.error().code);
}
