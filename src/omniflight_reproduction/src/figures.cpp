#include <algorithm>
#include <cctype>

#include "chapters.hpp"

namespace omniflight::reproduction {

const std::vector<Figure>& figures() {
  static const std::vector<Figure> all = [] {
    std::vector<Figure> out;
    for (auto chapter : {chapter_4, chapter_5, chapter_6, chapter_7, appendix})
      for (Figure& figure : chapter()) out.push_back(std::move(figure));
    return out;
  }();
  return all;
}

const Figure* find_figure(const std::string& id) {
  std::string wanted;
  for (const char c : id) wanted += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (wanted.rfind("figure ", 0) == 0) wanted = wanted.substr(7);
  const auto& all = figures();
  const auto at = std::find_if(all.begin(), all.end(), [&](const Figure& f) {
    std::string own;
    for (const char c : std::string(f.id))
      own += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return own == wanted;
  });
  return at == all.end() ? nullptr : &*at;
}

}  // namespace omniflight::reproduction
