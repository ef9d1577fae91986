// omniflight_proof_generate: draws cases, flies them on the independent plant, seals the truth.
//   omniflight_proof_generate --out DIR --seal DIR [--cases N] [--nulls N] [--level L] [--jobs N]
// Writes DIR/cases/case-0001/{flight.csv.gz, told.yaml} ..., DIR/vehicle/ (nominal), DIR/commitment.json
// (hashes) and, into the seal, truth.json (mode 600). What is unfinished stays in the seal; nothing is
// published before everything is there, so that times and order tell nothing. Resumes after a kill.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "case_aliases.hpp"
#include "case_make.hpp"
#include "case_next.hpp"
#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  DrawOptions draw;
  std::string out, seal, vehicle = "omnimorph";
  bool tuning = false, next = false, quiet = false;
  int jobs = 0;
};

/// The salt of a campaign that is resumed must be the same, and so must what it is asked for.
Status settle_salt(Options& o) {
  const fs::path file = fs::path(o.seal) / "draw.json";
  const json asked = {{"cases", o.draw.cases},
                      {"nulls", o.draw.nulls},
                      {"level", o.draw.level},
                      {"tuning", o.tuning},
                      {"vehicle", o.vehicle}};
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
  if (o.draw.salt.empty()) {
    auto salt = fresh_salt();
    if (!salt) return Failure(salt.error());
    o.draw.salt = *salt;
  }
  return write_private(file, json{{"salt", o.draw.salt}, {"asked", asked}}.dump(1));
}

/// One case into the staging part of the seal: recording and told first, truth last; a truth that is there
/// means that the case is complete.
Status stage(const Options& o, const vehicle::Vehicle& vehicle, const std::vector<Mechanism>& mechanisms,
             const CasePlan& plan) {
  const fs::path folder = fs::path(o.seal) / "staging" / plan.id;
  if (fs::exists(folder / "truth.json")) return {};
  auto made = make_case(vehicle, mechanisms, plan, o.draw.salt, o.draw.sealed);
  // a case whose trials were stopped is another one
  if (interrupted()) return fail(ErrorCode::incomplete, "stopped", "", "The same command resumes");
  if (!made) {
    Error e = made.error();
    e.where = plan.id + ": " + e.where;
    return Failure(e);
  }
  if (auto ok = make_private_folder(folder); !ok) return ok;
  if (auto ok = write_private(folder / "flight.csv.gz", made->recording); !ok) return ok;
  if (auto ok = write_private(folder / "told.yaml", made->told); !ok) return ok;
  return write_private(folder / "truth.json", to_json(Seal{"", "", "", {made->truth}}));
}

Status publish(const Options& o, const std::vector<CasePlan>& plans) {
  Seal seal{o.draw.salt, o.draw.sealed ? "sealed" : "tuning", {}, {}};
  auto program = files::sha256_file("/proc/self/exe");
  if (program) seal.program = *program;
  const fs::path out(o.out), staging = fs::path(o.seal) / "staging";
  std::error_code ec;
  for (const CasePlan& p : plans) {
    auto text = files::read_file(staging / p.id / "truth.json", files::kMegabyte);
    if (!text) return Failure(text.error());
    auto one = read_seal(*text, (staging / p.id / "truth.json").string());
    if (!one) return Failure(one.error());
    seal.cases.push_back(one->cases.at(0));
  }
  const std::string truth = to_json(seal);
  if (auto ok = write_private(fs::path(o.seal) / "truth.json", truth); !ok) return ok;
  for (const CasePlan& p : plans) {  // in one go, in the shuffled order
    fs::create_directories(out / "cases" / p.id, ec);
    for (const char* name : {"flight.csv.gz", "told.yaml"}) {
      auto bytes = files::read_file(staging / p.id / name, std::size_t{64} << 20);
      if (!bytes) return Failure(bytes.error());
      if (auto ok = write_neutral(out / "cases" / p.id / name, *bytes); !ok) return ok;
    }
  }
  auto digests = digest_folder(out / "cases");
  if (!digests) return Failure(digests.error());
  const json commitment = {{"schema", "omniflight.proof_commitment/1"},
                           {"truth_sha256", files::sha256_hex(truth)},
                           {"recordings_sha256", files::sha256_hex(manifest_text(*digests))},
                           {"aliases_sha256", files::sha256_hex(alias_table())},
                           {"generator_sha256", seal.program},
                           {"cases", plans.size()}};
  return files::write_file_atomic(out / "commitment.json", commitment.dump(1) + "\n");
}

/// Flies what the frozen answers ask for, each in the world of its case. What cannot be read or flown is left
/// out: the scorer counts it as not resolved.
Status fly_next(const Options& o, const vehicle::Vehicle& vehicle, const std::vector<Mechanism>& mechanisms,
                const std::vector<CasePlan>& plans) {
  const fs::path out(o.out);
  if (!fs::exists(out / "answers.sha256"))
    return bad_input("the first answers are not frozen", (out / "answers.sha256").string(),
                     "Let the campaign freeze them before their proposals are flown");
  std::error_code ec;
  fs::create_directories(out / "next", ec);
  std::vector<const CasePlan*> asked;
  for (const CasePlan& p : plans)
    if (fs::is_regular_file(out / "answers" / p.id / "next_flight.yaml", ec)) asked.push_back(&p);
  Progress progress("flying what was proposed", static_cast<double>(asked.size()), "flights", o.quiet);
  int done = 0;
  for (const CasePlan* p : asked) {
    if (interrupted()) return fail(ErrorCode::incomplete, "stopped", "", "The same command resumes");
    progress.update(++done);
    if (fs::exists(out / "next" / p->id)) continue;
    const fs::path file = out / "answers" / p->id / "next_flight.yaml";
    auto text = files::read_file(file, files::kMegabyte);
    auto path = text ? read_next_flight(*text, file.string()) : Result<Path>(Failure(text.error()));
    auto made = path ? fly_again(vehicle, mechanisms, *p, o.draw.salt, o.draw.sealed, *path)
                     : Result<MadeCase>(Failure(path.error()));
    if (interrupted()) return fail(ErrorCode::incomplete, "stopped", "", "The same command resumes");
    if (!made) {
      std::cerr << p->id << ": the proposed flight is left out: " << made.error().text() << "\n";
      continue;
    }
    const fs::path part = out / "next" / ("." + p->id), whole = out / "next" / p->id;
    fs::create_directories(part, ec);
    if (auto ok = write_neutral(part / "flight.csv.gz", made->recording); !ok) return ok;
    if (auto ok = write_neutral(part / "told.yaml", made->told); !ok) return ok;
    fs::rename(part, whole, ec);
    if (ec) return bad_input("cannot be put in place: " + ec.message(), whole.string());
  }
  progress.finish();
  return {};
}

Status copy_vehicle(const Options& o, const vehicle::Vehicle& vehicle) {
  const fs::path from = fs::path(vehicle.file).parent_path(), to = fs::path(o.out) / "vehicle";
  std::error_code ec;
  fs::create_directories(to, ec);
  for (const auto& file : fs::directory_iterator(from, ec)) {
    if (!file.is_regular_file(ec)) continue;
    auto bytes = files::read_file(file.path(), 16 * files::kMegabyte);
    if (!bytes) return Failure(bytes.error());
    if (auto ok = write_neutral(to / file.path().filename(), *bytes); !ok) return ok;
  }
  if (ec) return bad_input("cannot be listed: " + ec.message(), from.string());
  return {};
}

Result<int> run(Options& o) {
  if (!o.draw.salt.empty() && o.draw.salt.size() < 8)
    return bad_input("is too short", "--salt", "Give 8 letters or more");
  o.draw.sealed = !o.tuning;
  auto vehicle = vehicle::load_vehicle(o.vehicle);
  if (!vehicle) return Failure(vehicle.error());
  if (auto ok = make_private_folder(o.seal); !ok) return Failure(ok.error());
  std::error_code ec;
  fs::create_directories(o.out, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), o.out, "Choose another --out");
  if (auto ok = settle_salt(o); !ok) return Failure(ok.error());
  if (auto ok = copy_vehicle(o, *vehicle); !ok) return Failure(ok.error());
  const auto parts = mechanisms(*vehicle);
  const auto plans = draw_cases(o.draw, parts);
  const bool complete = fs::exists(fs::path(o.out) / "commitment.json");
  if (o.next) {
    if (!complete) return bad_input("there is no campaign yet", o.out, "Generate it first");
    if (auto ok = fly_next(o, *vehicle, parts, plans); !ok) return Failure(ok.error());
    return 0;
  }
  if (!complete) {
    std::atomic<std::size_t> next{0}, done{0};
    std::mutex mutex;
    std::optional<Error> error;
    Progress progress("hiding effects", static_cast<double>(plans.size()), "cases", o.quiet);
    const auto work = [&] {
      while (!interrupted()) {
        const std::size_t k = next++;
        if (k >= plans.size()) return;
        const auto ok = stage(o, *vehicle, parts, plans[k]);
        const std::lock_guard lock(mutex);
        if (!ok && !error) error = ok.error();
        if (error) return;
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
      return fail(ErrorCode::incomplete,
                  fmt::format("stopped after {} of {} cases", done.load(), plans.size()), "",
                  "The same command resumes");
    if (auto ok = publish(o, plans); !ok) return Failure(ok.error());
  }
  auto commitment = files::read_file(fs::path(o.out) / "commitment.json", files::kMegabyte);
  if (!commitment) return Failure(commitment.error());
  std::cout << *commitment << std::flush;
  return 0;
}

}  // namespace
}  // namespace omniflight::proof

int main(int argc, char** argv) {
  using namespace omniflight;
  CLI::App app(
      "Draws cases of the concealed-effect proof, flies them on the independent plant, seals the truth");
  proof::Options o;
  app.add_option("--out", o.out, "Folder that the analysis sees")->required();
  app.add_option("--seal", o.seal, "Folder that it must not see")->required();
  app.add_option("--cases", o.draw.cases, "Cases with effects")->check(CLI::Range(0, 100000));
  app.add_option("--nulls", o.draw.nulls, "Cases without")->check(CLI::Range(0, 100000));
  app.add_option("--level", o.draw.level, "Only cases of this level")
      ->check(CLI::IsMember({"L1", "L2", "L3", "L4", "L5", "L6"}));
  app.add_option("--vehicle", o.vehicle, "Nominal vehicle");
  app.add_option("--salt", o.draw.salt, "For tests only; a proof draws its own");
  app.add_flag("--tuning", o.tuning, "Draw from the tuning box: other shapes and magnitudes");
  app.add_flag("--next", o.next, "Fly what the frozen answers propose, in the worlds of their cases");
  app.add_option("--jobs", o.jobs, "Flights at once")->check(CLI::Range(1, 64));
  app.add_flag("--quiet", o.quiet, "No progress");
  CLI11_PARSE(app, argc, argv);
  install_interrupt_handler();
  const auto result = proof::run(o);
  if (result) return *result;
  std::cerr << "omniflight_proof_generate: " << result.error().text() << "\n";
  return static_cast<int>(result.error().code);
}
