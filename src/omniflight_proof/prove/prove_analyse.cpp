#include "prove_analyse.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <list>
#include <nlohmann/json.hpp>
#include <thread>

#include "omniflight_core/progress.hpp"
#include "omniflight_files/files.hpp"
#include "seal.hpp"

namespace omniflight::proof {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uid_t kNobody = 65534;

/// A folder that the confined process may write into.
Status writable_folder(const fs::path& folder, Confinement confinement) {
  std::error_code ec;
  fs::remove_all(folder, ec);
  fs::create_directories(folder, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), folder.string(), "Choose another --out");
  if (confinement == Confinement::other_user && chown(folder.c_str(), kNobody, kNobody) != 0)
    return bad_input("cannot be given to another user", folder.string(), "Choose another --out");
  return {};
}

Result<std::vector<std::string>> case_names(const fs::path& cases) {
  std::vector<std::string> out;
  std::error_code ec;
  for (const auto& entry : fs::directory_iterator(cases, ec))
    if (entry.is_directory(ec)) out.push_back(entry.path().filename().string());
  if (ec || out.empty()) return bad_input("has no cases", cases.string(), "Generate them first");
  std::sort(out.begin(), out.end());
  return out;
}

struct Running {
  std::string name;
  fs::path part;
  ConfinedChild child;
};

Confined run_of(const AnalyseOptions& o, const std::string& name, const fs::path& part) {
  Confined c;
  c.confinement = o.confinement;
  c.seal = o.places.seal;
  c.limit_s = o.limit_s;
  c.log = (part / "log.txt").string();
  const fs::path in = o.places.cases() / name;
  c.arguments = {o.command, "diagnose", (in / "flight.csv.gz").string()};
  if (o.second) c.arguments.push_back((o.places.next() / name / "flight.csv.gz").string());
  const std::string vehicle = o.vehicle.empty() ? (in / "vehicle.yaml").string() : o.vehicle;
  c.arguments.insert(c.arguments.end(),
                     {"--vehicle", vehicle, "--out", part.string(), "--quiet", "--jobs", "1"});
  if (o.ablation.empty() && !o.vehicle.empty())
    c.arguments.emplace_back("--refly-recorded");
  else if (!o.ablation.empty())
    c.arguments.insert(c.arguments.end(), {"--ablation", o.ablation});
  return c;
}

/// What stays: answer, model, and how it went; the rest would only fill the disk. Put in place as a whole.
Status settle(Running& r, const fs::path& answer) {
  std::error_code ec;
  const json run = {{"exit_code", r.child.exit_code()},
                    {"seconds", std::round(100 * r.child.seconds()) / 100},
                    {"out_of_time", r.child.out_of_time()}};
  std::vector<fs::path> extra;
  for (const auto& file : fs::directory_iterator(r.part, ec)) {
    const std::string name = file.path().filename().string();
    if (name != "diagnosis.json" && name != "model.yaml" && name != "next_flight.yaml" && name != "log.txt" &&
        name != "baselines.json")
      extra.push_back(file.path());
  }
  for (const auto& file : extra) fs::remove_all(file, ec);
  if (geteuid() == 0)
    for (const auto& file : fs::directory_iterator(r.part, ec)) {
      if (lchown(file.path().c_str(), 0, 0) != 0)
        return bad_input("cannot be taken back", file.path().string());
    }
  if (geteuid() == 0 && chown(r.part.c_str(), 0, 0) != 0)
    return bad_input("cannot be taken back", r.part.string());
  if (auto ok = files::write_file_atomic(r.part / "run.json", run.dump(1) + "\n"); !ok) return ok;
  fs::rename(r.part, answer, ec);
  if (ec) return bad_input("cannot be put in place: " + ec.message(), r.part.string());
  return {};
}

/// What the probe says inside the confinement, run in the folder `trial`; an error when something leaks or
/// hinders.
Result<json> ask_probe(const AnalyseOptions& o, const fs::path& trial) {
  if (auto ok = writable_folder(trial, o.confinement); !ok) return Failure(ok.error());
  auto names = case_names(o.places.cases());
  if (!names) return Failure(names.error());
  Confined c;
  c.confinement = o.confinement;
  c.seal = o.places.seal;
  c.limit_s = 60;
  c.log = (trial / "probe.json").string();
  c.arguments = {o.self,
                 "--probe",
                 o.places.seal.string(),
                 "--probe-secret",
                 o.places.truth().string(),
                 "--probe-readable",
                 (o.places.cases() / names->front() / "flight.csv.gz").string(),
                 "--probe-writable",
                 trial.string(),
                 "--probe-parent",
                 std::to_string(getpid())};
  auto code = run_confined(c);
  if (!code) return Failure(code.error());
  auto text = files::read_file(trial / "probe.json", files::kMegabyte);
  const json said = text ? json::parse(*text, nullptr, false) : json();
  if (*code != 0 || said.is_discarded() || !said.contains("leaks"))
    return fail(ErrorCode::internal, fmt::format("the probe ended with {}", *code),
                (trial / "probe.json").string());
  json probe = said;
  probe["schema"] = "omniflight.proof_probe/1";
  probe["confinement"] = to_string(o.confinement);
  probe["sealed"] = o.confinement != Confinement::none && said["leaks"].empty();
  return probe;
}

/// What the probe's answer means for going on.
Status judge_probe(const AnalyseOptions& o, const json& said) {
  if (!said["hindered"].empty())
    return bad_input("the analysis " + said["hindered"][0].get<std::string>(), o.places.out.string(),
                     "Choose an --out that every user may enter, for instance under /tmp or /var/tmp");
  if (o.confinement != Confinement::none && !said["leaks"].empty())
    return bad_input("the analysis could " + said["leaks"][0].get<std::string>(), o.places.seal.string(),
                     "Choose another --seal, or --allow-unsealed (the result says so)");
  return {};
}

}  // namespace

Status check_confinement(const AnalyseOptions& o) {
  const auto said = ask_probe(o, o.places.out / "working" / "probe");
  if (!said) return Failure(said.error());
  if (auto ok = files::write_file_atomic(o.places.probe(), said->dump(1) + "\n"); !ok) return ok;
  return judge_probe(o, *said);
}

Status analyse_case(AnalyseOptions o, const std::string& name, const fs::path& into) {
  std::error_code ec;
  const auto confinement = choose_confinement(o.places.seal, o.allow_unsealed);
  if (!confinement) return Failure(confinement.error());
  o.confinement = *confinement;
  // the folders of attempts at one case differ, and so do those of their confined parts
  const fs::path part = o.places.out / "working" / (name + into.filename().string()),
                 trial = part.string() + "-probe";
  const auto said = ask_probe(o, trial);
  fs::remove_all(trial, ec);
  if (!said) return Failure(said.error());
  if (auto ok = judge_probe(o, *said); !ok) return ok;
  if (auto ok = writable_folder(part, o.confinement); !ok) return ok;
  Running r{name, part, ConfinedChild()};
  auto child = ConfinedChild::start(run_of(o, name, part));
  if (!child) return Failure(child.error());
  r.child = std::move(*child);
  while (!r.child.poll()) {
    if (interrupted()) {
      r.child = ConfinedChild();
      fs::remove_all(part, ec);
      return fail(ErrorCode::incomplete, "interrupted", name);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return settle(r, into / "answer");
}

namespace {

/// Cases without an answer by the executor: each into OUT/working/done-.../CASE, and from there into its
/// place.
Status analyse_elsewhere(const AnalyseOptions& o, const std::vector<std::string>& open, Progress& progress,
                         std::size_t before) {
  auto executor = jobs::make_executor(o.executor);
  if (!executor) return Failure(executor.error());
  const std::string kind = !o.ablation.empty() ? o.ablation : o.second ? "second" : "first";
  const fs::path done = o.places.out / "working" / ("done-" + kind);
  jobs::Work work;
  work.program = o.self;
  work.run_task = {"run-task"};
  work.folder = o.places.out / "working" / ("jobs-" + kind);
  work.stop = interrupted;
  work.progress = [&](std::size_t count) { progress.update(static_cast<double>(before + count)); };
  for (const std::string& name : open) {
    jobs::Job job{
        name,
        done / name,
        {"--analyse", name, "--into", jobs::kOut, "--out", o.places.out.string(), "--seal",
         o.places.seal.string(), "--command", o.command, "--limit-s", fmt::format("{}", o.limit_s)}};
    if (!o.vehicle.empty()) job.command.insert(job.command.end(), {"--vehicle", o.vehicle});
    if (!o.ablation.empty()) job.command.insert(job.command.end(), {"--ablation", o.ablation});
    if (o.second) job.command.emplace_back("--of-second");
    if (o.allow_unsealed) job.command.emplace_back("--allow-unsealed");
    work.jobs.push_back(std::move(job));
  }
  const auto ran = (*executor)->run(work);
  if (!ran) return Failure(ran.error());
  for (const jobs::Job& job : work.jobs) {
    std::error_code ec;
    if (is_done(job)) fs::rename(job.folder / "answer", o.answers() / job.name, ec);
    if (ec) return bad_input("cannot be put in place: " + ec.message(), job.folder.string());
  }
  if (ran->stopped || !ran->missing.empty())
    return fail(ErrorCode::incomplete,
                fmt::format("{} of {} cases have no answer{}", ran->missing.size(), open.size(),
                            ran->missing.empty() ? "" : "; the first: " + ran->missing.front().reason),
                "", "The same command resumes");
  return {};
}

}  // namespace

Status analyse(const AnalyseOptions& o) {
  auto names = case_names(o.flights());
  if (!names) return Failure(names.error());
  if (o.most > 0 && names->size() > o.most) names->resize(o.most);
  std::error_code ec;
  fs::create_directories(o.answers(), ec);
  const fs::path working = o.places.out / "working";
  fs::create_directories(working, ec);
  std::vector<std::string> open;
  for (const auto& n : *names)
    if (!fs::exists(o.answers() / n)) open.push_back(n);
  const std::size_t before = names->size() - open.size();
  Progress progress(!o.ablation.empty() ? "diagnosing with " + o.ablation
                    : o.second          ? "diagnosing with the proposed flights"
                                        : "diagnosing",
                    static_cast<double>(names->size()), "cases", o.quiet);
  progress.update(static_cast<double>(before));
  if (o.executor.name != "local") {
    if (!open.empty())
      if (auto ok = analyse_elsewhere(o, open, progress, before); !ok) return ok;
    progress.finish();
    fs::remove_all(working, ec);
    return {};
  }
  std::list<Running> running;
  std::size_t next = 0, done = before;
  while (next < open.size() || !running.empty()) {
    if (interrupted()) {
      running.clear();
      progress.finish();
      return fail(ErrorCode::incomplete, fmt::format("stopped after {} of {} cases", done, names->size()), "",
                  "The same command resumes");
    }
    while (next < open.size() && running.size() < static_cast<std::size_t>(std::max(1, o.jobs))) {
      Running r{open[next++], {}, ConfinedChild()};
      r.part = working / r.name;
      if (auto ok = writable_folder(r.part, o.confinement); !ok) return ok;
      auto child = ConfinedChild::start(run_of(o, r.name, r.part));
      if (!child) return Failure(child.error());
      r.child = std::move(*child);
      running.push_back(std::move(r));
    }
    bool ended = false;
    for (auto it = running.begin(); it != running.end();) {
      if (!it->child.poll()) {
        ++it;
        continue;
      }
      ended = true;
      if (auto ok = settle(*it, o.answers() / it->name); !ok) return ok;
      it = running.erase(it);
      progress.update(static_cast<double>(++done));
    }
    if (!ended) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  fs::remove_all(working, ec);
  return {};
}

Status run_baselines(const AnalyseOptions& o) {
  const fs::path kept = o.places.answers() / "baselines.json";
  if (fs::exists(kept)) return {};
  const fs::path part = o.places.out / "working" / "baselines";
  if (auto ok = writable_folder(part, o.confinement); !ok) return ok;
  Confined c;
  c.confinement = o.confinement;
  c.seal = o.places.seal;
  c.limit_s = 6 * 3600;
  c.log = (part / "log.txt").string();
  c.arguments = {o.baselines, o.places.cases().string(),         "--vehicle", o.vehicle,
                 "--out",     (part / "baselines.json").string()};
  auto child = ConfinedChild::start(c);
  if (!child) return Failure(child.error());
  while (!child->poll()) {
    if (interrupted())
      return fail(ErrorCode::incomplete, "stopped in the baselines", "", "The same command resumes");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  auto text = files::read_file(part / "baselines.json", 256 * files::kMegabyte);
  if (child->exit_code() != 0 || !text)
    return fail(ErrorCode::internal, fmt::format("the baselines ended with {}", child->exit_code()), c.log);
  if (auto ok = files::write_file_atomic(kept, *text); !ok) return ok;
  std::error_code ec;
  fs::remove_all(o.places.out / "working", ec);
  return {};
}

Result<std::string> freeze(const fs::path& answers, const fs::path& frozen) {
  auto digests = digest_folder(answers);
  if (!digests) return Failure(digests.error());
  const std::string text = manifest_text(*digests);
  if (fs::exists(frozen)) {
    auto before = files::read_file(frozen, 64 * files::kMegabyte);
    if (!before) return Failure(before.error());
    if (*before != text)
      return bad_input("the answers are not those that were frozen", frozen.string(),
                       "Answers must not be touched; begin a new campaign");
    return files::sha256_hex(text);
  }
  for (const auto& [path, digest] : *digests) chmod((answers / path).c_str(), 0444);
  if (auto ok = files::write_file_atomic(frozen, text); !ok) return Failure(ok.error());
  return files::sha256_hex(text);
}

}  // namespace omniflight::proof
