// omniflight_proof_score: opens the seal and judges the frozen answers. It shares the file formats with
// generator and campaign, and no more.
//   omniflight_proof_score --out DIR --seal DIR
// Refuses to score when the truth is not the one that was committed to, or the answers are not those that
// were frozen.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "case_aliases.hpp"
#include "omniflight_files/files.hpp"
#include "prove_files.hpp"
#include "prove_result.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Result<json> read_json(const fs::path& file, std::size_t most = 64u << 20) {
  auto text = files::read_file(file, most);
  if (!text) return Failure(text.error());
  json j = json::parse(*text, nullptr, false);
  if (j.is_discarded()) return bad_input("is no JSON", file.string());
  return j;
}

Result<Seal> open_seal(const Places& places, const json& commitment, ProofResult& result) {
  auto text = files::read_file(places.truth(), std::size_t{256} << 20);
  if (!text) return Failure(text.error());
  result.truth_sha256 = files::sha256_hex(*text);
  if (commitment.value("truth_sha256", "") != result.truth_sha256)
    return bad_input("is not the truth that was committed to before the analysis", places.truth().string(),
                     "This campaign proves nothing; begin a new one");
  if (commitment.value("aliases_sha256", "") != files::sha256_hex(alias_table()))
    return bad_input("the table of aliases has changed since the cases were drawn",
                     places.commitment().string(), "Score with the program of that version");
  return read_seal(*text, places.truth().string());
}

Result<std::string> frozen_hash(const fs::path& answers, const fs::path& frozen) {
  auto before = files::read_file(frozen, std::size_t{64} << 20);
  if (!before) return Failure(before.error());
  auto now = digest_folder(answers);
  if (!now) return Failure(now.error());
  if (manifest_text(*now) != *before)
    return bad_input("the answers are not those that were frozen", frozen.string(),
                     "This campaign proves nothing; begin a new one");
  return files::sha256_hex(*before);
}

Status check_frozen(const Places& places, ProofResult& result) {
  auto first = frozen_hash(places.answers(), places.frozen());
  if (!first) return Failure(first.error());
  result.answers_sha256 = *first;
  if (fs::exists(places.ablations())) {
    auto third = frozen_hash(places.ablations(), places.frozen_ablations());
    if (!third) return Failure(third.error());
    result.ablations_sha256 = *third;
  }
  if (!fs::exists(places.answers_next())) return {};
  auto second = frozen_hash(places.answers_next(), places.frozen_next());
  if (!second) return Failure(second.error());
  result.answers_next_sha256 = *second;
  return {};
}

/// What somebody who only sees the folders would have to guess.
constexpr const char* kNothing = "nothing";

std::string label(const Truth& t) {
  return t.effects.empty() ? kNothing : t.effects.size() > 1 ? "several" : t.effects[0].id;
}

Answer answer_in(const fs::path& folder) {
  auto text = files::read_file(folder / "diagnosis.json", std::size_t{64} << 20);
  if (text) return read_answer(*text);
  Answer none;
  none.problem = "no diagnosis.json";
  return none;
}

/// The analysis without a safeguard each, and whole on the same cases.
void judge_ablations(const Places& places, const Seal& seal, const std::map<std::string, Answer>& whole,
                     ProofResult& result) {
  std::error_code ec;
  std::vector<Truth> some;
  for (const auto& folder : fs::directory_iterator(places.ablations(), ec)) {
    std::map<std::string, Answer> said;
    some.clear();
    for (const Truth& t : seal.cases)
      if (fs::is_directory(folder.path() / t.id, ec)) {
        some.push_back(t);
        said[t.id] = answer_in(folder.path() / t.id);
      }
    result.ablations[folder.path().filename().string()] = score(some, said);
  }
  if (!some.empty()) result.ablations[kWhole] = score(some, whole);
}

using Answers = std::map<std::string, Answer>;

/// By method, as omniflight_proof_baselines writes them.
Result<std::map<std::string, Answers>> methods_in(const fs::path& file) {
  auto baselines = read_json(file, std::size_t{256} << 20);
  if (!baselines) return Failure(baselines.error());
  std::map<std::string, Answers> out;
  const json methods = baselines->value("baselines", json::object());
  for (const auto& [name, cases] : methods.items()) {
    Answers& said = out[name];
    for (const auto& [id, answer] : cases.items()) said[id] = read_answer(answer.dump());
  }
  return out;
}

void print(const Scores& scores) {
  std::cout << fmt::format("{:<52} {:>18} {:>16}  {:<16} {:<16} {}\n", "score", "came out", "95 % interval",
                           "must", "goal", "verdict");
  for (const Score& s : scores.table) {
    const std::string value = s.n == 0     ? "-"
                              : !s.is_rate ? fmt::format("{:.3g} {}", s.value, s.unit)
                                           : fmt::format("{:.1f} % ({}/{})", 100 * s.value, s.k, s.n);
    const std::string interval =
        s.is_rate && s.n > 0 ? fmt::format("{:.1f}..{:.1f} %", 100 * s.interval.low, 100 * s.interval.high)
                             : "";
    std::cout << fmt::format("{:<52} {:>18} {:>16}  {:<16} {:<16} {}\n", s.name, value, interval, s.must,
                             s.goal, s.verdict == Score::Verdict::information ? "" : to_string(s.verdict));
  }
}

/// The last name in a folder of cases; empty where there is none.
std::string last_in(const fs::path& folder) {
  std::string last;
  std::error_code ec;
  for (const auto& entry : fs::directory_iterator(folder, ec))
    last = std::max(last, entry.path().filename().string());
  return last;
}

Result<int> run(const Places& places) {
  ProofResult result;
  auto commitment = read_json(places.commitment());
  if (!commitment) return Failure(commitment.error());
  result.commitment = *commitment;
  if (auto ok = check_frozen(places, result); !ok) return Failure(ok.error());  // before the seal is opened
  auto seal = open_seal(places, *commitment, result);
  if (!seal) return Failure(seal.error());
  result.salt = seal->salt;
  result.box = seal->box;
  auto probe = read_json(places.probe());
  if (!probe) return Failure(probe.error());
  result.probe = *probe;

  std::map<std::string, Answer> answers;
  std::vector<double> times;
  for (const Truth& t : seal->cases) {
    const fs::path folder = places.answers() / t.id;
    Answer a = answer_in(folder);
    if (auto ran = read_json(folder / "run.json")) {
      const double s = ran->value("seconds", 0.0);
      times.push_back(s);
      result.analysis_s += s;
      result.longest_s = std::max(result.longest_s, s);
      if (!a.given)
        a.problem += fmt::format(" (exit {}{})", ran->value("exit_code", -1),
                                 ran->value("out_of_time", false) ? ", out of time" : "");
    }
    answers[t.id] = std::move(a);
  }
  result.median_s = median(times);
  std::map<std::string, Answer> second;
  for (const Truth& t : seal->cases)
    if (auto text = files::read_file(places.answers_next() / t.id / "diagnosis.json", std::size_t{64} << 20))
      second[t.id] = read_answer(*text);
  // with --proposals flights wait behind the last one that was analysed, whether it was answered or not
  const std::string flown = last_in(places.next()), analysed = last_in(places.answers_next()),
                    last_asked = analysed < flown ? analysed : "";
  Answers oracle;
  for (const fs::path& file : {places.answers() / "baselines.json", places.oracle()}) {
    if (!fs::exists(file)) continue;
    auto methods = methods_in(file);
    if (!methods) return Failure(methods.error());
    for (auto& [name, said] : *methods) {
      result.baselines[name] = score(seal->cases, said);
      if (file == places.oracle()) oracle = std::move(said);
    }
  }
  result.scores = score(seal->cases, answers, second, oracle, last_asked);
  judge_ablations(places, *seal, answers, result);
  auto outside = look_from_outside(places.cases());
  if (!outside) return Failure(outside.error());
  std::map<std::string, std::string> labels;
  for (const Truth& t : seal->cases) labels[t.id] = label(t);
  std::vector<std::string> which, whether;
  for (const auto& o : *outside) {
    which.push_back(labels[o.id]);
    whether.emplace_back(labels[o.id] == kNothing ? kNothing : "something");
  }
  result.leak = guess(*outside, which);
  result.leak_whether = guess(*outside, whether);

  if (auto ok = files::write_file_atomic(places.out / "proof.json", to_json(result).dump(1) + "\n"); !ok)
    return Failure(ok.error());
  if (auto ok = write_report(result, places.out / "report.html"); !ok) return Failure(ok.error());
  print(result.scores);
  for (const auto& [what, leak] :
       {std::pair("which effect", result.leak), {"whether any", result.leak_whether}})
    std::cout << fmt::format("guessing from the outside {}: {:.1f} % right, chance {:.1f} %, p = {:.2f}{}\n",
                             what, 100 * leak.accuracy, 100 * leak.chance, leak.p_value,
                             leak.p_value < kLeakMust ? "  IT LEAKS: " + leak.feature : "");
  if (!result.probe.value("sealed", false))
    std::cout << "NOT SEALED: the analysis could have read the truth\n";
  return 0;
}

}  // namespace
}  // namespace omniflight::proof

int main(int argc, char** argv) {
  using namespace omniflight;
  CLI::App app("Opens the seal of a concealed-effect proof and scores the frozen answers");
  std::string out, seal;
  bool quiet = false;
  app.add_option("--out", out, "Folder of the campaign")->required();
  app.add_option("--seal", seal, "Folder of the truth")->required();
  app.add_flag("--quiet", quiet, "No table");
  CLI11_PARSE(app, argc, argv);
  if (quiet) std::cout.setstate(std::ios_base::badbit);
  const auto result = proof::run({out, seal});
  if (result) return *result;
  std::cerr << "omniflight_proof_score: " << result.error().text() << "\n";
  return static_cast<int>(result.error().code);
}
