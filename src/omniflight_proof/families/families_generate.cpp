// omniflight_proof_families: draws cases of the families, flies them on the independent plant, seals the
// truth.
//   omniflight_proof_families --out DIR --seal DIR [--cases N] [--nulls N] [--tuning --seed N] [--jobs N]
// Writes DIR/cases/case-0001/{flight.csv.gz, vehicle.yaml, told.yaml} ..., DIR/commitment.json (hashes) and,
// into the seal, truth.json (mode 600). What is unfinished stays in the seal; a sealed run publishes nothing
// before everything is there. A tuning run publishes cases as they come. Resumes after a kill.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "family_make.hpp"
#include "family_publish.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kFiles[] = {"flight.csv.gz", "vehicle.yaml", "told.yaml"};

struct Options {
  FamilyDrawOptions draw;
  std::string out, seal;
  bool tuning = false, quiet = false;
  long seed = -1;
  int jobs = 0;
};

/// A resumed run has the same salt, and must be asked for the same.
Status settle_salt(Options& o) {
  const fs::path file = fs::path(o.seal) / "draw.json";
  const json asked = {{"cases", o.draw.cases},    {"nulls", o.draw.nulls},       {"tuning", o.tuning},
                      {"seed", o.seed},           {"vehicles", o.draw.vehicles}, {"effects", o.draw.effects},
                      {"longest", o.draw.longest}};
  if (fs::exists(file)) {
    auto text = files::read_file(file, files::kMegabyte);
    if (!text) return Failure(text.error());
    const json before = json::parse(*text, nullptr, false);
    if (before.is_discarded() || !before.contains("salt") || !before.contains("asked"))
      return bad_input("is damaged", file.string(), "Use another --seal and --out");
    if (before["asked"] != asked)
      return bad_input("was begun with other options: " + before["asked"].dump(), file.string(),
                       "Use the same ones to resume, or another --seal and --out");
    o.draw.salt = before["salt"];
    return {};
  }
  if (o.tuning) {
    o.draw.salt = fmt::format("tuning of the families, {}", o.seed);
  } else if (o.draw.salt.empty()) {
    auto salt = fresh_salt();
    if (!salt) return Failure(salt.error());
    o.draw.salt = *salt;
  }
  return write_private(file, json{{"salt", o.draw.salt}, {"asked", asked}}.dump(1));
}

Status publish_case(const Options& o, const std::string& id) {
  const fs::path from = fs::path(o.seal) / "staging" / id, to = fs::path(o.out) / "cases" / id;
  std::error_code ec;
  fs::create_directories(to, ec);
  for (const char* name : kFiles) {
    auto bytes = files::read_file(from / name, std::size_t{256} << 20);
    if (!bytes) return Failure(bytes.error());
    if (auto ok = write_neutral(to / name, *bytes); !ok) return ok;
  }
  return {};
}

/// A truth that is there means that the case is complete.
Status stage(const Options& o, const LoaderKnows& loader, const FamilyPlan& plan) {
  const fs::path folder = fs::path(o.seal) / "staging" / plan.id;
  if (!fs::exists(folder / "truth.json")) {
    auto made = make_family_case(plan, o.draw.salt, o.draw.box, loader);
    // a case whose trials were stopped is another one
    if (interrupted()) return fail(ErrorCode::incomplete, "stopped", "", "The same command resumes");
    if (!made) {
      Error e = made.error();
      if (e.where.rfind(plan.id, 0) != 0) e.where = plan.id + ": " + e.where;
      return Failure(e);
    }
    if (auto ok = make_private_folder(folder); !ok) return ok;
    const std::string* const contents[] = {&made->recording, &made->vehicle, &made->told};
    for (std::size_t k = 0; k < 3; ++k)
      if (auto ok = write_private(folder / kFiles[k], *contents[k]); !ok) return ok;
    if (auto ok = write_private(folder / "truth.json", to_json(FamilySeal{"", "", "", {made->truth}})); !ok)
      return ok;
  }
  return o.tuning ? publish_case(o, plan.id) : Status{};
}

Status publish(const Options& o, const std::vector<FamilyPlan>& plans) {
  FamilySeal seal{o.draw.salt, o.tuning ? "tuning" : "sealed", {}, {}};
  for (const FamilyPlan& p : plans) {
    const fs::path file = fs::path(o.seal) / "staging" / p.id / "truth.json";
    auto text = files::read_file(file, files::kMegabyte);
    if (!text) return Failure(text.error());
    auto one = read_family_seal(*text, file.string());
    if (!one) return Failure(one.error());
    seal.cases.push_back(one->cases.at(0));
  }
  if (!o.tuning)
    for (const FamilyPlan& p : plans)
      if (auto ok = publish_case(o, p.id); !ok) return ok;
  return commit_family_run(o.out, o.seal, std::move(seal));
}

/// A case that is lost at every vigour, or too small to count, is drawn anew in another place and then with
/// another realisation, up to this often.
constexpr int kRedraws = 18;

Status stage_or_redraw(const Options& o, const LoaderKnows& loader, const FamilyPlan& plan) {
  Status last;
  for (int k = 0; k < kRedraws; ++k) {
    last = stage(o, loader, k > 0 ? draw_again(plan, o.draw, k) : plan);
    if (last) return last;
    if (last.error().code != ErrorCode::incomplete && last.error().code != ErrorCode::impossible) return last;
    if (interrupted()) return last;
  }
  return last;
}

Status make_all(const Options& o, const std::vector<FamilyPlan>& plans) {
  const LoaderKnows loader = what_the_loader_knows();
  std::atomic<std::size_t> next{0}, done{0};
  std::mutex mutex;
  std::optional<Error> error;
  Progress progress("hiding effects", static_cast<double>(plans.size()), "cases", o.quiet);
  const auto work = [&] {
    while (!interrupted()) {
      const std::size_t k = next++;
      if (k >= plans.size()) return;
      const auto begin = std::chrono::steady_clock::now();
      const auto ok = stage_or_redraw(o, loader, plans[k]);
      const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      const std::lock_guard lock(mutex);
      if (!ok && !error) error = ok.error();
      if (error) return;
      if (took > 60 && !o.quiet) std::cerr << fmt::format("{}: {:.0f} s\n", plans[k].id, took);
      progress.update(static_cast<double>(++done));
    }
  };
  std::vector<std::thread> threads;
  const unsigned n =
      o.jobs > 0 ? static_cast<unsigned>(o.jobs) : std::max(1u, std::thread::hardware_concurrency());
  for (unsigned k = 0; k < n; ++k) threads.emplace_back(work);
  for (auto& t : threads) t.join();
  progress.finish();
  if (error) return Failure(*error);
  if (interrupted())
    return fail(ErrorCode::incomplete, fmt::format("stopped after {} of {} cases", done.load(), plans.size()),
                "", "The same command resumes");
  return publish(o, plans);
}

Result<int> run(Options& o) {
  if (o.tuning != (o.seed >= 0))
    return bad_input(o.tuning ? "needs a --seed" : "is for --tuning only; a sealed run draws its own salt",
                     "--seed", "For instance --tuning --seed 1");
  if (!o.draw.salt.empty() && (o.tuning || o.draw.salt.size() < 8))
    return bad_input("is for tests of a sealed run, and has 8 letters or more", "--salt");
  o.draw.box = o.tuning ? Box::tuning : Box::sealed;
  if (auto ok = make_private_folder(o.seal); !ok) return Failure(ok.error());
  std::error_code ec;
  fs::create_directories(o.out, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), o.out, "Choose another --out");
  if (auto ok = settle_salt(o); !ok) return Failure(ok.error());
  const fs::path commitment = fs::path(o.out) / "commitment.json";
  if (!fs::exists(commitment)) {
    auto plans = draw_families(o.draw);
    if (!plans) return Failure(plans.error());
    if (auto ok = make_all(o, *plans); !ok) return Failure(ok.error());
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
      "Draws worlds of families that differ in vehicle, controller, start, manoeuvre, signals, noise and "
      "calibration, "
      "hides effects in them, flies them on the independent plant, seals the truth.\n"
      "Example: omniflight_proof_families --tuning --seed 1 --cases 60 --nulls 20 --out tune --seal "
      "tune.seal");
  proof::Options o;
  app.add_option("--out", o.out, "Folder that an analysis sees")->required();
  app.add_option("--seal", o.seal, "Folder that it must not see (mode 700)")->required();
  app.add_option("--cases", o.draw.cases, "Cases with hidden effects")->check(CLI::Range(0, 100000));
  app.add_option("--nulls", o.draw.nulls, "Cases without")->check(CLI::Range(0, 100000));
  app.add_option("--longest", o.draw.longest, "Longest flight [s]")->check(CLI::Range(10.0, 240.0));
  app.add_flag("--tuning", o.tuning, "Draw from the tuning boxes, without what is marked unseen");
  app.add_option("--seed", o.seed, "Of a tuning run")->check(CLI::Range(0L, 1000000000L));
  app.add_option("--vehicles", o.draw.vehicles, "Only these kinds")
      ->check(CLI::IsMember(
          {"quadrotor_37g", "quadrotor_1200g", "hexarotor", "hexarotor_tilted", "omnimorph", "octorotor"}));
  app.add_option("--effects", o.draw.effects, "Only these ids ('unknown': from no library)");
  app.add_option("--salt", o.draw.salt, "For tests only; a sealed run draws its own");
  app.add_option("--jobs", o.jobs, "Flights at once")->check(CLI::Range(1, 64));
  app.add_flag("--quiet", o.quiet, "No progress");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(ErrorCode::bad_input);
  }
  install_interrupt_handler();
  const auto result = proof::run(o);
  if (result) return *result;
  std::cerr << "omniflight_proof_families: " << result.error().text() << "\n";
  return static_cast<int>(result.error().code);
}
