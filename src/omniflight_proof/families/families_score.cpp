// omniflight_proof_families_score: judges answers to a families run. Reads only diagnosis.json of each case
// and the truth, so that two analyses can be compared on the same cases.
//   omniflight_proof_families_score --answers DIR --seal DIR --out DIR [--commitment FILE]
#include <CLI/CLI.hpp>
#include <iostream>

#include "family_aliases.hpp"
#include "family_scores.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::proof {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Options {
  std::string answers, seal, out, commitment;
  bool quiet = false;
};

Status check_commitment(const Options& o, const std::string& truth) {
  if (o.commitment.empty()) return {};
  auto text = files::read_file(o.commitment, files::kMegabyte);
  if (!text) return Failure(text.error());
  const json c = json::parse(*text, nullptr, false);
  if (c.is_discarded() || !c.is_object()) return bad_input("is no commitment", o.commitment);
  if (c.value("truth_sha256", "") != files::sha256_hex(truth))
    return bad_input("is not to this truth", o.commitment, "These answers prove nothing; begin a new run");
  if (c.value("aliases_sha256", "") != files::sha256_hex(family_alias_table()))
    return bad_input("is to another table of aliases", o.commitment,
                     "Score with the program of that version");
  return {};
}

Result<int> run(const Options& o) {
  const fs::path file = fs::path(o.seal) / "truth.json";
  auto text = files::read_file(file, std::size_t{256} << 20);
  if (!text) return Failure(text.error());
  if (auto ok = check_commitment(o, *text); !ok) return Failure(ok.error());
  auto seal = read_family_seal(*text, file.string());
  if (!seal) return Failure(seal.error());
  std::map<std::string, Answer> answers;
  std::size_t given = 0;
  for (const FamilyCase& c : seal->cases) {
    Answer& a = answers[c.truth.id];
    auto said = files::read_file(fs::path(o.answers) / c.truth.id / "diagnosis.json", std::size_t{64} << 20);
    if (said)
      a = read_answer(*said);
    else
      a.problem = "no diagnosis.json";
    given += a.given;
  }
  if (given == 0)
    return bad_input("has no answer to any of " + std::to_string(seal->cases.size()) + " cases", o.answers,
                     "It must hold case-0001/diagnosis.json and so on");
  const FamilyScores scores = score_families(seal->cases, answers);
  std::error_code ec;
  fs::create_directories(o.out, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), o.out, "Choose another --out");
  json j = to_json(scores);
  j["box"] = seal->box;
  j["truth_sha256"] = files::sha256_hex(*text);
  if (auto ok = files::write_file_atomic(fs::path(o.out) / "family_scores.json", j.dump(1) + "\n"); !ok)
    return Failure(ok.error());
  const std::string table = to_text(scores);
  if (auto ok = files::write_file_atomic(fs::path(o.out) / "family_scores.txt", table); !ok)
    return Failure(ok.error());
  const std::string headline =
      seal->box == "sealed" ? "Drawn from the sealed boxes." : "A tuning run: it proves nothing.";
  if (auto ok = write_family_report(scores, headline, fs::path(o.out) / "report.html"); !ok)
    return Failure(ok.error());
  if (!o.quiet) std::cout << headline << "\n" << table << std::flush;
  return 0;
}

}  // namespace
}  // namespace omniflight::proof

int main(int argc, char** argv) {
  using namespace omniflight;
  CLI::App app(
      "Judges answers to a families run by family, vehicle, flight, level and effect.\n"
      "Example: omniflight_proof_families_score --answers answers --seal tune.seal --out scores");
  proof::Options o;
  app.add_option("--answers", o.answers, "Folder with CASE/diagnosis.json")->required();
  app.add_option("--seal", o.seal, "Folder with truth.json")->required();
  app.add_option("--out", o.out, "Folder for family_scores.json, family_scores.txt and report.html")
      ->required();
  app.add_option("--commitment", o.commitment, "Refuse a truth that this commitment.json is not to");
  app.add_flag("--quiet", o.quiet, "No table");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(ErrorCode::bad_input);
  }
  const auto result = proof::run(o);
  if (result) return *result;
  std::cerr << "omniflight_proof_families_score: " << result.error().text() << "\n";
  return static_cast<int>(result.error().code);
}
