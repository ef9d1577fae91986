// What came of a campaign, in words.
#include <fmt/format.h>

#include <algorithm>

#include "campaign.hpp"

namespace omniflight::cli {

std::string flown_in_words(const std::vector<std::string>& verdicts, std::size_t planned) {
  const auto count = [&](const char* verdict) {
    return static_cast<std::size_t>(std::count(verdicts.begin(), verdicts.end(), verdict));
  };
  std::string out = fmt::format("{} of {} flights flown", count(kFlown), planned);
  std::size_t told = count(kFlown);
  for (const auto& [verdict, words] : {std::pair{kFlownBadly, "flown badly"}, {kLost, "lost"}})
    if (const std::size_t n = count(verdict); n > 0) {
      out += fmt::format(", {} {}", n, words);
      told += n;
    }
  if (told < planned) out += fmt::format(", {} not flown to the end", planned - told);
  return out;
}

std::string headline(const std::vector<Judgement>& judgements, std::size_t not_flown) {
  std::string first;
  std::size_t missed = 0;
  for (const Judgement& j : judgements) {
    if (j.met()) continue;
    if (missed++ == 0) first = j.words();
  }
  if (missed > 0)
    return "Not as expected: " + first + (missed > 1 ? fmt::format("; and {} more", missed - 1) : "");
  if (not_flown > 0)
    return fmt::format("As expected so far; {} flight{} no result yet", not_flown,
                       not_flown == 1 ? " has" : "s have");
  return "Every flight ended as expected";
}

}  // namespace omniflight::cli
