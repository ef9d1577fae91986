// omniflight_proof_baselines: textbook methods on the recordings of a campaign. It sees what the analysis
// sees.
//   omniflight_proof_baselines CASES --vehicle YAML --out baselines.json
#include <CLI/CLI.hpp>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "baseline_methods.hpp"
#include "case_truth.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"
#include "score_stats.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json finding_json(const NamedTerm& t) {
  json parameters = json::array();
  for (std::size_t k = 0; k < t.parameters.size(); ++k)
    parameters.push_back(
        {{"name", t.parameters[k]},
         {"value", t.values[k]},
         {"interval95", {t.values[k] - 1.96 * t.errors[k], t.values[k] + 1.96 * t.errors[k]}}});
  return {{"effect", t.id},
          {"stage", t.stage},
          {"probability", 1},
          {"parameters", parameters},
          {"cannot_be_told_apart_from", json::array()}};
}

/// In the words of diagnosis.json, so that one scorer judges all.
json answer_json(const BaselineAnswer& a) {
  json findings = json::array();
  for (const NamedTerm& t : a.terms) findings.push_back(finding_json(t));
  return {
      {"schema", "omniflight.diagnosis/1"},
      {"verdict", !a.terms.empty() ? "explained"
                  : a.mismatch     ? "unexplained"
                                   : "nothing_missing"},
      {"findings", findings},
      {"unexplained", a.mismatch && a.terms.empty() ? json::array({{{"stage", "wrench"}}}) : json::array()},
      {"mismatch", json::array()}};
}

/// Tracking error of each axis against the median of flights of the same kind: the thesis's metric, with
/// every other flight of the campaign as the simulation.
json tracking_ratios(const std::map<std::string, std::pair<std::string, Vec3>>& flights) {
  std::map<std::string, Vec3> usual;
  for (const auto& [id, flight] : flights) {
    if (usual.count(flight.first)) continue;
    for (int k = 0; k < 3; ++k) {
      std::vector<double> all;
      for (const auto& [other, f] : flights)
        if (f.first == flight.first) all.push_back(f.second[k]);
      usual[flight.first][k] = median(all);
    }
  }
  json out = json::object();
  for (const auto& [id, flight] : flights) {
    BaselineAnswer a;
    for (int k = 0; k < 3; ++k) {
      const double ratio = flight.second[k] / std::max(1e-12, usual[flight.first][k]);
      a.mismatch = a.mismatch || ratio > 1.5 || ratio < 0.67;
    }
    out[id] = answer_json(a);
  }
  return out;
}

/// What is told comes out as it is; only the sizes are found.
Result<int> ask_oracle(const std::string& cases, const vehicle::Vehicle& vehicle, const std::string& truth,
                       const std::string& out) {
  const auto text = files::read_file(truth, 256 * files::kMegabyte);
  if (!text) return Failure(text.error());
  const auto seal = read_seal(*text, truth);
  if (!seal) return Failure(seal.error());
  json answers = json::object();
  for (const Truth& t : seal->cases) {
    std::vector<std::string> ids;
    for (const TrueEffect& e : t.effects) ids.push_back(e.id);
    BaselineAnswer a;
    if (!ids.empty()) {
      auto recording = recording::load(fs::path(cases) / t.id / "flight.csv.gz");
      if (!recording) return Failure(recording.error());
      if (auto data = prepare_baseline(*recording, vehicle)) a = oracle(*data, ids);
    }
    json said = answer_json(a);
    for (const TrueEffect& e : t.effects) {
      if (e.id == "unknown") {
        said["verdict"] = "unexplained";
        said["unexplained"].push_back({{"stage", e.stage}, {"variables", e.variables}});
      } else if (std::none_of(a.terms.begin(), a.terms.end(),
                              [&](const NamedTerm& n) { return n.id == e.id; })) {
        said["verdict"] = "explained";
        said["findings"].push_back(finding_json({e.id, e.stage, 0, {}, {}, {}}));
      }
    }
    answers[t.id] = said;
  }
  const json result = {{"schema", "omniflight.proof_baselines/1"},
                       {"baselines", {{"B6 oracle, told what is hidden", answers}}}};
  if (auto ok = files::write_file_atomic(out, result.dump() + "\n"); !ok) return Failure(ok.error());
  return 0;
}

Result<int> run(const std::string& cases, const std::string& vehicle_file, const std::string& truth,
                const std::string& out) {
  auto vehicle = vehicle::load_vehicle(vehicle_file);
  if (!vehicle) return Failure(vehicle.error());
  if (!truth.empty()) return ask_oracle(cases, *vehicle, truth, out);
  json all = json::object();
  std::map<std::string, std::pair<std::string, Vec3>> flights;
  std::vector<fs::path> folders;
  std::error_code ec;
  for (const auto& e : fs::directory_iterator(cases, ec))
    if (e.is_directory(ec)) folders.push_back(e.path());
  if (ec || folders.empty()) return bad_input("has no cases", cases);
  std::sort(folders.begin(), folders.end());
  for (const auto& folder : folders) {
    const std::string id = folder.filename().string();
    auto recording = recording::load(folder / "flight.csv.gz");
    if (!recording) return Failure(recording.error());
    auto data = prepare_baseline(*recording, *vehicle);
    if (!data) continue;  // no answer
    flights[id] = {data->flight, data->tracking_rmse};
    all["B2 least squares, t-tests"][id] = answer_json(least_squares(*data));
    all["B3 thresholded (SINDy)"][id] = answer_json(thresholded(*data));
    all["B4 BIC stepwise, white"][id] = answer_json(stepwise(*data, false));
    all["B4 BIC stepwise, coloured"][id] = answer_json(stepwise(*data, true));
    all["B5 splines"][id] = answer_json(black_box(*data));
    if (auto commanded = prepare_baseline(*recording, *vehicle, true))
      all["B4 coloured, commands only"][id] = answer_json(stepwise(*commanded, true));
    std::cout << id << std::endl;
  }
  all["B1 tracking ratios"] = tracking_ratios(flights);
  const json result = {{"schema", "omniflight.proof_baselines/1"}, {"baselines", all}};
  if (auto ok = files::write_file_atomic(out, result.dump() + "\n"); !ok) return Failure(ok.error());
  return 0;
}

}  // namespace
}  // namespace omniflight::proof

int main(int argc, char** argv) {
  using namespace omniflight;
  CLI::App app("Textbook methods on the recordings of a concealed-effect proof");
  std::string cases, vehicle, out, truth;
  app.add_option("cases", cases, "Folder of the cases")->required();
  app.add_option("--vehicle", vehicle, "Nominal vehicle")->required();
  app.add_option("--out", out, "File of the answers")->required();
  app.add_option("--oracle", truth, "Opened truth: only fit what is there");
  CLI11_PARSE(app, argc, argv);
  const auto result = proof::run(cases, vehicle, truth, out);
  if (result) return *result;
  std::cerr << "omniflight_proof_baselines: " << result.error().text() << "\n";
  return static_cast<int>(result.error().code);
}
