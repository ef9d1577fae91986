#include "score_leak.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>

#include "omniflight_core/random.hpp"
#include "omniflight_files/files.hpp"

namespace omniflight::proof {

namespace fs = std::filesystem;

namespace {

double seconds(const timespec& t) {
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Rank instead of value: distances mean the same in every feature.
void to_ranks(std::vector<std::vector<double>>& columns) {
  for (auto& column : columns) {
    std::vector<double> sorted = column;
    std::sort(sorted.begin(), sorted.end());
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    const double scale = sorted.size() > 1 ? 1.0 / static_cast<double>(sorted.size() - 1) : 0.0;
    for (double& x : column)
      x = scale * static_cast<double>(std::lower_bound(sorted.begin(), sorted.end(), x) - sorted.begin());
  }
}

/// Indices of the 5 nearest other cases; ties by index, so that equal features say nothing.
using Neighbours = std::vector<std::array<std::size_t, 5>>;
Neighbours neighbours(const std::vector<std::vector<double>>& columns, std::size_t n, Random& random) {
  std::vector<std::size_t> shuffled(n);
  std::iota(shuffled.begin(), shuffled.end(), std::size_t{0});
  for (std::size_t k = n; k > 1; --k) std::swap(shuffled[k - 1], shuffled[random.next() % k]);
  Neighbours out(n);
  std::vector<std::pair<double, std::size_t>> by(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t s = 0; s < n; ++s) {
      const std::size_t j = shuffled[s];
      double d = 0;
      for (const auto& c : columns) d += (c[i] - c[j]) * (c[i] - c[j]);
      by[s] = {j == i ? 1e300 : d, s};
    }
    std::partial_sort(by.begin(), by.begin() + 5, by.end());
    for (std::size_t k = 0; k < 5; ++k) out[i][k] = shuffled[by[k].second];
  }
  return out;
}

double accuracy(const Neighbours& near, const std::vector<int>& labels, int classes) {
  int right = 0;
  std::vector<int> votes(static_cast<std::size_t>(classes));
  for (std::size_t i = 0; i < near.size(); ++i) {
    std::fill(votes.begin(), votes.end(), 0);
    for (const std::size_t j : near[i]) ++votes[static_cast<std::size_t>(labels[j])];
    right += static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin()) == labels[i];
  }
  return static_cast<double>(right) / static_cast<double>(std::max<std::size_t>(1, near.size()));
}

struct Told {
  std::vector<double> numbers;
  std::string keys;  ///< the text without its numbers
};
/// A number begins after a blank or a bracket and goes on to the next blank, comma or bracket.
Told split_numbers(const std::string& text) {
  Told out;
  for (std::size_t k = 0; k < text.size();) {
    const bool begins = k == 0 || text[k - 1] == ' ' || text[k - 1] == '[';
    char* end = nullptr;
    const double value = begins ? std::strtod(text.c_str() + k, &end) : 0;
    if (begins && end != text.c_str() + k && text[k] != ' ' && text[k] != '\n') {
      out.numbers.push_back(value);
      k = static_cast<std::size_t>(end - text.c_str());
    } else {
      if (text[k] != ' ') out.keys += text[k];
      ++k;
    }
  }
  return out;
}

}  // namespace

std::string outside_feature(std::size_t place) {
  static const std::vector<std::string> names{"number in the name",
                                              "place in the listing",
                                              "files",
                                              "bytes",
                                              "blocks",
                                              "bytes beside",
                                              "modified",
                                              "changed",
                                              "folder changed",
                                              "inode",
                                              "owner and mode",
                                              "gzip header"};
  return place < names.size() ? names[place]
                              : fmt::format("number {} of told.yaml", place - names.size() + 1);
}

Result<std::vector<Outside>> look_from_outside(const fs::path& cases) {
  std::vector<Outside> out;
  std::error_code ec;
  double place = 0;
  std::string keys;
  for (const auto& entry : fs::directory_iterator(cases, ec)) {  // in the order of the file system
    ++place;
    if (!entry.is_directory(ec)) continue;
    Outside one{entry.path().filename().string(), {}};
    std::string digits;
    for (const char c : one.id)
      if (c >= '0' && c <= '9') digits += c;
    Told told;
    double count = 0, bytes = 0, blocks = 0, beside = 0, modified = 0, changed = 0, inode = 0, mode = 0,
           header = 0;
    for (const auto& file : fs::directory_iterator(entry.path(), ec)) {
      struct stat s {};
      if (stat(file.path().c_str(), &s) != 0) continue;
      ++count;
      modified += seconds(s.st_mtim);
      mode += static_cast<double>(s.st_mode) + 1e6 * s.st_uid;
      if (file.path().extension() == ".gz") {
        bytes += static_cast<double>(s.st_size);
        blocks += static_cast<double>(s.st_blocks);
        changed = seconds(s.st_ctim);
        inode = static_cast<double>(s.st_ino);
        const auto text = files::read_file(file.path(), std::size_t{64} << 20);
        if (!text) return Failure(text.error());
        for (std::size_t k = 3; k < 10 && k < text->size(); ++k)
          header = header * 7 + static_cast<unsigned char>((*text)[k]);
      } else {
        beside += static_cast<double>(s.st_size);
        if (file.path().filename() == "told.yaml") {
          const auto text = files::read_file(file.path(), 1 << 16);
          if (!text) return Failure(text.error());
          told = split_numbers(*text);
        }
      }
    }
    if (told.keys != (out.empty() ? told.keys : keys))
      return bad_input("has other keys than the other cases", (entry.path() / "told.yaml").string());
    keys = told.keys;
    struct stat s {};
    stat(entry.path().c_str(), &s);
    one.features = {digits.empty() ? 0 : std::stod(digits),
                    place,
                    count,
                    bytes,
                    blocks,
                    beside,
                    modified,
                    changed,
                    seconds(s.st_ctim),
                    inode,
                    mode,
                    header};
    one.features.insert(one.features.end(), told.numbers.begin(), told.numbers.end());
    out.push_back(std::move(one));
  }
  if (ec) return bad_input("cannot be listed: " + ec.message(), cases.string());
  std::sort(out.begin(), out.end(), [](const Outside& a, const Outside& b) { return a.id < b.id; });
  return out;
}

LeakResult guess(const std::vector<Outside>& cases, const std::vector<std::string>& labels, int shuffles) {
  LeakResult result;
  const std::size_t n = cases.size();
  if (n < 8 || labels.size() != n) return result;
  std::map<std::string, int> ids;
  std::vector<int> label(n);
  for (std::size_t i = 0; i < n; ++i)
    label[i] = ids.emplace(labels[i], static_cast<int>(ids.size())).first->second;
  const int classes = static_cast<int>(ids.size());
  std::vector<std::vector<double>> columns(cases[0].features.size(), std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t f = 0; f < columns.size(); ++f) columns[f][i] = cases[i].features[f];
  to_ranks(columns);
  Random random(1, "leak");
  std::vector<Neighbours> views;
  std::vector<std::string> names;
  for (std::size_t f = 0; f < columns.size(); ++f) {
    views.push_back(neighbours({columns[f]}, n, random));
    names.push_back(outside_feature(f));
  }
  views.push_back(neighbours(columns, n, random));
  names.emplace_back("all together");
  const auto best = [&](const std::vector<int>& l, std::string* name) {
    double top = -1;
    for (std::size_t v = 0; v < views.size(); ++v)
      if (const double a = accuracy(views[v], l, classes); a > top) {
        top = a;
        if (name) *name = names[v];
      }
    return top;
  };
  result.accuracy = best(label, &result.feature);
  int as_good = 0;
  for (int k = 0; k < shuffles; ++k) {
    for (std::size_t i = n; i > 1; --i) std::swap(label[i - 1], label[random.next() % i]);
    const double a = best(label, nullptr);
    result.chance += a / shuffles;
    as_good += a >= result.accuracy;
  }
  result.p_value = (as_good + 1.0) / (shuffles + 1.0);
  return result;
}

}  // namespace omniflight::proof
