// The protocol: hashes, walls, frozen answers, what counts as right, and that nothing outside the data tells.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "case_aliases.hpp"
#include "omniflight_files/files.hpp"
#include "prove_sandbox.hpp"
#include "score.hpp"
#include "score_leak.hpp"
#include "seal.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "prove-XXXXXX").string();
    path = mkdtemp(name.data());
    chmod(path.c_str(), 0755);
  }
  ~Folder() {
    std::error_code ec;
    fs::remove_all(path, ec);
  }
  fs::path path;
};

Truth truth(const std::string& id, Kind kind, std::vector<TrueEffect> effects, double magnitude = 1) {
  Truth t;
  t.id = id;
  t.level = "L1";
  t.kind = kind;
  t.flight = "designed";
  t.magnitude = magnitude;
  t.effects = std::move(effects);
  t.noise = {0.15, 0.15, 0.15, 0.01, 0.01, 0.01};
  t.wrench = {0, 0, 0.15, 0, 0, 0};
  return t;
}
TrueEffect effect(const std::string& id, std::vector<TrueParameter> parameters = {}) {
  return {id, "wrench", "", 1, std::move(parameters), {}};
}
Answer answer(const std::string& findings, const std::string& verdict = "explained",
              const std::string& unexplained = "[]", const std::string& fit = "{}") {
  return read_answer(R"({"schema": "omniflight.diagnosis/1", "verdict": ")" + verdict +
                     R"(", "mismatch": [], "findings": )" + findings + R"(, "unexplained": )" + unexplained +
                     R"(, "fit": )" + fit + "}");
}
std::string found(const std::string& id, const std::string& set = "[]",
                  const std::string& parameters = "[]") {
  return R"({"effect": ")" + id + R"(", "stage": "wrench", "cannot_be_told_apart_from": )" + set +
         R"(, "parameters": )" + parameters + "}";
}
const Score& line(const Scores& scores, const std::string& name) {
  for (const auto& s : scores.table)
    if (s.name == name) return s;
  ADD_FAILURE() << "no score " << name;
  return scores.table.front();
}

TEST(Score, WilsonIntervalIsThatOfThePaper) {
  const Interval none = wilson(0, 60), one = wilson(81, 263);
  EXPECT_DOUBLE_EQ(none.low, 0);
  EXPECT_NEAR(none.high, 0.0602, 1e-4);
  EXPECT_NEAR(one.low, 0.2553, 1e-4);  // Newcombe 1998, method 3
  EXPECT_NEAR(one.high, 0.3662, 1e-4);
  EXPECT_DOUBLE_EQ(median({3, 1, 2, 10}), 2.5);
}

TEST(Score, AnAlarmIsAnythingSaidAboutANominalFlight) {
  const auto quiet = answer("[]", "nothing_missing");
  std::map<std::string, Answer> answers{{"a", quiet},
                                        {"b", answer("[" + found("wind") + "]")},
                                        {"c", answer("[]", "unexplained", R"([{"stage": "wrench"}])")},
                                        {"d", answer("[]", "unusable")}};
  std::vector<Truth> truths;
  for (const char* id : {"a", "b", "c", "d", "e"}) truths.push_back(truth(id, Kind::null, {}, 0));
  const Scores s = score(truths, answers);  // e has no answer
  EXPECT_EQ(line(s, "false alarms").k, 2);
  EXPECT_EQ(line(s, "false alarms").n, 5);
  EXPECT_EQ(line(s, "refused").k, 2);
  EXPECT_EQ(line(s, "false alarms").verdict, Score::Verdict::short_of);
}

TEST(Score, NamingANuisanceThatIsThereIsNoAlarm) {
  Truth t = truth("a", Kind::null, {}, 0);
  t.present = {"clock_offset"};
  EXPECT_FALSE(judge(t, answer("[" + found("clock_offset") + "]")).alarm);
  EXPECT_TRUE(judge(t, answer("[" + found("clock_offset") + "," + found("wind") + "]")).alarm);
  t.present.clear();
  EXPECT_TRUE(judge(t, answer("[" + found("clock_offset") + "]")).alarm);
}

TEST(Score, OnlyDeclaredAliasesAreMerged) {
  const Truth t = truth("a", Kind::single, {effect("thrust_scale")});
  const Judged j = judge(t, answer("[" + found("payload_mass") + "]"));
  EXPECT_TRUE(j.top1);
  EXPECT_EQ(j.truth, j.said) << "as aliases they are one";
  EXPECT_EQ(j.named, "payload_mass");
  EXPECT_NE(j.hidden, j.named) << "the report says what was hidden, and what was named";
  EXPECT_FALSE(judge(t, answer("[" + found("hung_cable") + "]")).top1);
  Truth level = t;
  level.flight = "T1";
  EXPECT_TRUE(judge(level, answer("[" + found("hung_cable") + "]")).top1);
  EXPECT_EQ(files::sha256_hex(alias_table()).size(), 64u);
}

TEST(Score, TheSetCountsWhenTheNameIsWrong) {
  const Truth t = truth("a", Kind::single, {effect("rotor_drag")});
  const Judged j = judge(t, answer("[" + found("parasitic_drag", R"(["rotor_drag", "wind"])") + "]"));
  EXPECT_FALSE(j.top1);
  EXPECT_TRUE(j.covered);
  EXPECT_EQ(j.set_size, 3);
  EXPECT_TRUE(j.stage);
}

TEST(Score, CombinationsMustBeExact) {
  const Truth t = truth("a", Kind::pair, {effect("com_offset"), effect("rotor_drag")});
  EXPECT_TRUE(judge(t, answer("[" + found("rotor_drag") + "," + found("com_offset") + "]")).exact);
  EXPECT_FALSE(judge(t, answer("[" + found("rotor_drag") + "]")).exact);
  EXPECT_FALSE(
      judge(t, answer("[" + found("rotor_drag") + "," + found("com_offset") + "," + found("wind") + "]"))
          .exact);
}

TEST(Score, WhatAnOracleSeesWellIsCountedBesideAll) {
  const auto pair = [](const char* id) {
    return truth(id, Kind::pair, {effect("com_offset"), effect("payload_mass")});
  };
  const auto oracle = [](const char* mass) {  // the centre of mass is 20 standard errors from nothing
    return answer("[" +
                  found("com_offset", "[]", R"([{"name": "x", "value": 10, "interval95": [9.02, 10.98]}])") +
                  "," + found("payload_mass", "[]", mass) + "]");
  };
  const char* well = R"([{"name": "mass", "value": 3, "interval95": [2.02, 3.98]}])";  // 6 standard errors
  const char* hardly = R"([{"name": "mass", "value": 1, "interval95": [0.02, 1.98]}])";
  const auto both = answer("[" + found("com_offset") + "," + found("payload_mass") + "]");
  const Scores s = score({pair("a"), pair("b")}, {{"a", both}, {"b", answer("[]")}}, {},
                         {{"a", oracle(well)}, {"b", oracle(hardly)}});
  EXPECT_EQ(line(s, "two effects exact").n, 2);
  EXPECT_EQ(line(s, "two effects exact").k, 1);
  const auto at = std::find_if(s.table.begin(), s.table.end(),
                               [](const Score& x) { return x.name == "two effects exact"; });
  ASSERT_NE(at + 1, s.table.end());
  EXPECT_EQ((at + 1)->name, "  of those that an oracle sees well");
  EXPECT_EQ((at + 1)->n, 1);
  EXPECT_EQ((at + 1)->k, 1);
  EXPECT_EQ((at + 1)->must, "");
}

TEST(Score, UnknownMustBeCalledSoWithStageAndVariable) {
  Truth t = truth("a", Kind::unknown, {effect("unknown")});
  t.effects[0].variables = {"speed"};
  EXPECT_TRUE(judge(t, answer("[]", "unexplained", R"([{"stage": "wrench", "depends_on": ["vx"]}])")).exact);
  EXPECT_FALSE(
      judge(t, answer("[]", "unexplained", R"([{"stage": "wrench", "depends_on": ["height"]}])")).exact);
  EXPECT_FALSE(judge(t, answer("[]", "unexplained", R"([{"stage": "motion", "depends_on": ["vx"]}])")).exact);
  EXPECT_FALSE(judge(t, answer("[" + found("rotor_drag") + "]", "explained",
                               R"([{"stage": "wrench", "depends_on": ["vx"]}])"))
                   .exact);
}

TEST(Score, ParametersAndHeldOutEnergy) {
  const Truth t = truth("a", Kind::single, {effect("payload_mass", {{"mass", 0.10, 0.10}})});
  const auto said = answer(
      "[" + found("payload_mass", "[]", R"([{"name": "mass", "value": 0.11, "interval95": [0.09, 0.12]}])") +
          "]",
      "explained", "[]", R"({"held_out": [{"channel": "Fz", "rms_before": 0.2121320, "rms_after": 0.15}]})");
  const Scores s = score({t}, {{"a", said}});
  EXPECT_NEAR(line(s, "parameter error, median").value, 10, 1e-9);
  EXPECT_EQ(line(s, "95 % interval covers").k, 1);
  EXPECT_NEAR(line(s, "held-out residual explained, of oracle, median").value, 100, 0.01);
}

TEST(Score, AmbiguityIsResolvedOnlyByTheRightNameAlone) {
  const auto proposing = [&](const std::string& findings) {
    Answer a = answer("[" + findings + "]");
    a.proposes = true;
    return a;
  };
  const Truth t = truth("a", Kind::single, {effect("hung_cable")});
  const std::map<std::string, Answer> first{{"a", proposing(found("payload_mass", R"(["hung_cable"])"))}};
  const char* name = "ambiguity resolved by the one proposed flight";
  EXPECT_EQ(line(score({t}, first), name).n, 1);
  EXPECT_EQ(line(score({t}, first), name).k, 0) << "a proposal that was not flown resolves nothing";
  EXPECT_EQ(line(score({t}, first, {{"a", answer("[" + found("hung_cable") + "]")}}), name).k, 1);
  EXPECT_EQ(line(score({t}, first, {{"a", answer("[" + found("payload_mass") + "]")}}), name).k, 0);
  EXPECT_EQ(line(score({t}, first, {{"a", answer("[" + found("hung_cable", R"(["wind"])") + "]")}}), name).k,
            0);
  EXPECT_EQ(line(score({t}, {{"a", answer("[" + found("hung_cable") + "]")}}), name).n, 0)
      << "it was never ambiguous";
  const std::map<std::string, Answer> told{{"a", answer("[" + found("hung_cable") + "]")}};
  const std::vector<Truth> both{t, truth("b", Kind::single, {effect("hung_cable")})};
  const std::map<std::string, Answer> two{{"a", first.at("a")}, {"b", first.at("a")}};
  EXPECT_EQ(line(score(both, two, told), name).n, 2) << "the second could not be flown";
  EXPECT_EQ(line(score(both, two, told, {}, "a"), name).n, 1) << "the second was not asked";
}

TEST(Score, HostileAnswersAreNotGiven) {
  for (
      const char* text :
      {"", "{", "[]", R"({"schema": "omniflight.diagnosis/1"})",
       R"({"schema": "omniflight.diagnosis/1", "verdict": 3, "findings": [], "unexplained": [], "mismatch": []})",
       R"({"schema": "omniflight.diagnosis/1", "verdict": "explained", "findings": {"a": 1}, "unexplained": [], "mismatch": []})"})
    EXPECT_FALSE(read_answer(text).given) << text;
}

TEST(Seal, TruthSurvivesWritingAndRefusesDamage) {
  Seal seal{"salt",
            "sealed",
            "abc",
            {truth("case-0001", Kind::pair, {effect("com_offset", {{"x", 0.1, 0.2}}), effect("wind")})}};
  seal.cases[0].present = {"gust"};
  auto back = read_seal(to_json(seal), "truth.json");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(to_json(*back), to_json(seal));
  EXPECT_FALSE(read_seal("{}", "truth.json"));
  std::string damaged = to_json(seal);
  damaged.replace(damaged.find("\"pair\""), 6, "\"many\"");
  auto refused = read_seal(damaged, "truth.json");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("'many' is no kind of case"), std::string::npos);
}

TEST(Seal, SaltsDifferAndStreamsAreApart) {
  auto a = fresh_salt(), b = fresh_salt();
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->size(), 64u);
  EXPECT_NE(*a, *b);
  EXPECT_EQ(draw("salt", "x").next(), draw("salt", "x").next());
  EXPECT_NE(draw("salt", "x").next(), draw("salt", "y").next());
}

TEST(Seal, RecordingsHaveOneSizeAndInflateToTheirContent) {
  Random random(1);
  for (const std::size_t n : {0u, 10u, 50000u}) {
    std::string content;
    for (std::size_t k = 0; k < n; ++k) content += static_cast<char>('0' + k * k % 10);
    auto gz = gzip_of_size(content, 100000, random);
    ASSERT_TRUE(gz);
    EXPECT_EQ(gz->size(), 100000u);
    auto back = files::gunzip(*gz, 1 << 20, "test");
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(*back, content);
  }
  std::string noise;
  for (int k = 0; k < 5000; ++k) noise += static_cast<char>(random.next());
  EXPECT_FALSE(gzip_of_size(noise, 1000, random));
}

TEST(Seal, FoldersAndFilesArePrivateOrNeutral) {
  Folder f;
  ASSERT_TRUE(make_private_folder(f.path / "seal"));
  ASSERT_TRUE(write_private(f.path / "seal" / "truth.json", "x"));
  ASSERT_TRUE(write_neutral(f.path / "a.csv.gz", "x"));
  struct stat s {};
  ASSERT_EQ(stat((f.path / "seal").c_str(), &s), 0);
  EXPECT_EQ(s.st_mode & 0777, 0700u);
  ASSERT_EQ(stat((f.path / "seal" / "truth.json").c_str(), &s), 0);
  EXPECT_EQ(s.st_mode & 0777, 0600u);
  ASSERT_EQ(stat((f.path / "a.csv.gz").c_str(), &s), 0);
  EXPECT_EQ(s.st_mtime, 946684800);
  chmod((f.path / "seal").c_str(), 0755);
  EXPECT_FALSE(make_private_folder(f.path / "seal"));
}

/// Runs `omniflight_proof_campaign --probe` under a confinement and returns what it could do.
nlohmann::json probed(Confinement confinement, const Folder& f) {
  const fs::path seal = f.path / "seal", working = f.path / "working";
  EXPECT_TRUE(make_private_folder(seal));
  EXPECT_TRUE(write_private(seal / "truth.json", "secret"));
  EXPECT_TRUE(write_neutral(f.path / "readable", "x"));
  fs::create_directories(working);
  chmod(working.c_str(), 0777);
  const std::string log = (f.path / "working" / "probe.json").string();
  auto code =
      run_confined({confinement,
                    seal,
                    {PROVE_CAMPAIGN, "--probe", seal.string(), "--probe-secret",
                     (seal / "truth.json").string(), "--probe-readable", (f.path / "readable").string(),
                     "--probe-writable", working.string(), "--probe-parent", std::to_string(getpid())},
                    log,
                    60});
  EXPECT_TRUE(code && *code == 0);
  auto text = files::read_file(log, 1 << 20);
  EXPECT_TRUE(text);
  return text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
}

TEST(Sandbox, TheAnalysisCannotReadTheSeal) {
  Folder f;
  ASSERT_TRUE(make_private_folder(f.path / "seal"));
  auto confinement = choose_confinement(f.path / "seal", false);
  if (!confinement) GTEST_SKIP() << "neither root nor user namespaces here: " << confinement.error().text();
  const auto said = probed(*confinement, f);
  ASSERT_TRUE(said.is_object());
  EXPECT_TRUE(said["leaks"].empty()) << said.dump(1);
  EXPECT_TRUE(said["hindered"].empty()) << said.dump(1);
  EXPECT_GE(said["refused"].size(), 6u);
}

TEST(Sandbox, TheProbeSeesAnOpenSeal) {
  Folder f;
  const auto said = probed(Confinement::none, f);
  ASSERT_TRUE(said.is_object());
  EXPECT_FALSE(said["leaks"].empty()) << "a probe that never finds anything proves nothing: " << said.dump(1);
}

TEST(Sandbox, WhatRunsInsideFindsTheConfigs) {
  Folder f;
  const fs::path configs = f.path / "configs", log = f.path / "log.txt";
  fs::create_directories(configs);
  ::setenv("OMNIFLIGHT_CONFIGS", configs.c_str(), 1);
  auto child = ConfinedChild::start({Confinement::none, "/nonexistent", {"/usr/bin/env"}, log.string(), 10});
  ::unsetenv("OMNIFLIGHT_CONFIGS");
  ASSERT_TRUE(child);
  while (!child->poll()) usleep(1000);
  EXPECT_EQ(child->exit_code(), 0);
  const auto said = files::read_file(log, 1 << 16);
  ASSERT_TRUE(said);
  EXPECT_NE(said->find("OMNIFLIGHT_CONFIGS=" + configs.string()), std::string::npos) << *said;
}

TEST(Sandbox, EndsWhatTakesTooLong) {
  auto child = ConfinedChild::start({Confinement::none, "/nonexistent", {"/bin/sleep", "30"}, "", 0.1});
  ASSERT_TRUE(child);
  while (!child->poll()) usleep(1000);
  EXPECT_TRUE(child->out_of_time());
  EXPECT_LT(child->seconds(), 10);
  EXPECT_NE(child->exit_code(), 0);
}

std::vector<Outside> cases_like(int n, bool telling, std::vector<std::string>& labels) {
  Random random(7);
  std::vector<Outside> out;
  for (int k = 0; k < n; ++k) {
    const int kind = static_cast<int>(random.next() % 4);
    labels.push_back(std::string("kind") + static_cast<char>('0' + kind));
    Outside o{"case-" + std::to_string(k), {}};
    for (std::size_t f = 0; f < 20; ++f) o.features.push_back(random.uniform());
    o.features[3] = telling ? 1000 + 10 * kind + random.uniform() : 1000;
    out.push_back(o);
  }
  return out;
}

TEST(Leak, TheClassifierFindsALeakAndOnlyALeak) {
  std::vector<std::string> labels, fair_labels;
  const auto leaking = cases_like(80, true, labels);
  const LeakResult found_out = guess(leaking, labels);
  EXPECT_GT(found_out.accuracy, 0.9);
  EXPECT_LT(found_out.p_value, 0.01);
  EXPECT_EQ(found_out.feature, "bytes");
  const auto fair = cases_like(80, false, fair_labels);
  EXPECT_GT(guess(fair, fair_labels).p_value, 0.02);
}

TEST(Leak, WhatIsToldIsLookedAtToo) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "prove_told";
  std::filesystem::remove_all(folder);
  const auto put = [&](const std::string& id, const std::string& told) {
    std::filesystem::create_directories(folder / id);
    ASSERT_TRUE(files::write_file_atomic(folder / id / "told.yaml", told));
  };
  put("case-1", "kp: [12.5    , -3e-2]\nnoise: {a_1: 0.08}\n");
  put("case-2", "kp: [7       , 4    ]\nnoise: {a_1: 0.24}\n");
  const auto seen = look_from_outside(folder);
  ASSERT_TRUE(seen) << seen.error().text();
  ASSERT_EQ(seen->size(), 2u);
  const auto& f = seen->at(0).features;
  ASSERT_GE(f.size(), 3u);
  EXPECT_EQ(std::vector<double>(f.end() - 3, f.end()), (std::vector<double>{12.5, -0.03, 0.08}));
  EXPECT_EQ(outside_feature(f.size() - 1), "number 3 of told.yaml");
  put("case-3", "kp: [7       , 4    ]\nother: {a_1: 0.24}\n");
  EXPECT_FALSE(look_from_outside(folder));
}

}  // namespace
}  // namespace omniflight::proof
