#include <algorithm>
#include <charconv>

#include "csv_columns.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_recording/formats.hpp"

namespace omniflight::recording {
namespace {

void append(std::string& out, double value) {
  char text[40];
  const auto end =
      std::to_chars(text, text + sizeof text, value).ptr;  // shortest text that reads back exactly
  out.append(text, static_cast<std::size_t>(end - text));
}

}  // namespace

std::string to_csv(const Recording& recording) {
  std::vector<const Signal*> signals;
  std::vector<double> times;
  for (const auto& [name, signal] : recording.signals) {
    if (signal.empty() || !find_spec(name)) continue;
    signals.push_back(&signal);
    times.insert(times.end(), signal.t_s.begin(), signal.t_s.end());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  std::string out = "t_s";
  for (const Signal* s : signals)
    for (int c = 0; c < s->width(); ++c) out += "," + column_of(s->name, c, static_cast<int>(s->width()));
  out += "\n";
  std::vector<std::size_t> next(signals.size(), 0);
  for (const double t : times) {
    append(out, t);
    for (std::size_t k = 0; k < signals.size(); ++k) {
      const Signal& s = *signals[k];
      const bool here = next[k] < s.t_s.size() && s.t_s[next[k]] == t;
      for (Eigen::Index c = 0; c < s.width(); ++c) {
        out += ',';
        if (here) append(out, s.values(static_cast<Eigen::Index>(next[k]), c));
      }
      if (here) ++next[k];
    }
    out += '\n';
  }
  return out;
}

Status write_csv(const Recording& recording, const std::filesystem::path& path) {
  return files::write_file_atomic(path, to_csv(recording));
}

}  // namespace omniflight::recording
