// The tags of a COLLADA file: what a reader of XML could be made to unfold.
#include <algorithm>
#include <optional>

#include "mesh_scan.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"
#include "text.hpp"
#include "tokens.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kMostDepth = 64, kMostTags = 1'000'000, kMostUnfolded = 100'000;
constexpr std::uint32_t kMostIndex = 100'000'000;
constexpr std::size_t kMostOffset = 31;  // of an input: the numbers of a corner

/// The value of an attribute of a tag; nothing where it has none.
std::optional<std::string_view> attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    std::size_t next = at + name.size();
    const bool begins =
        at > 0 && (tag[at - 1] == ' ' || tag[at - 1] == '\t' || tag[at - 1] == '\n' || tag[at - 1] == '\r');
    while (next < tag.size() && tag[next] == ' ') ++next;
    if (!begins || next >= tag.size() || tag[next] != '=') continue;
    ++next;
    while (next < tag.size() && tag[next] == ' ') ++next;
    if (next >= tag.size() || (tag[next] != '"' && tag[next] != '\'')) return std::string_view();
    const std::size_t end = tag.find(tag[next], next + 1);
    if (end == std::string_view::npos) return std::string_view();
    return tag.substr(next + 1, end - next - 1);
  }
  return std::nullopt;
}

class TagScan {
 public:
  TagScan(std::string_view bytes, const std::string& name) : rest_(bytes), size_(bytes.size()), name_(name) {}

  Status run(MeshHeader& header) {
    while (true) {
      const std::size_t begin = rest_.find('<');
      if (begin == std::string_view::npos) break;
      rest_.remove_prefix(begin + 1);
      if (rest_.starts_with("!--")) {
        const std::size_t end = rest_.find("-->");
        if (end == std::string_view::npos) return refuse_mesh("a comment does not end", name_);
        rest_.remove_prefix(end + 3);
        continue;
      }
      if (rest_.starts_with("!")) return refuse_mesh("the XML has declarations or CDATA", name_);
      const std::size_t end = rest_.find('>');
      if (end == std::string_view::npos) return refuse_mesh("a tag does not end", name_);
      const std::string_view tag = rest_.substr(0, end);
      rest_.remove_prefix(end + 1);
      if (++tags_ > kMostTags) return refuse_mesh("more than a million tags", name_);
      if (auto ok = look(tag, header); !ok) return ok;
    }
    if (depth_ != 0) return refuse_mesh("the file ends within an element", name_);
    if (!collada_) return refuse_mesh("there is no COLLADA element", name_);
    // every instance of a node repeats that node and what is below it
    if (instances_ > 0 && nodes_ * (instances_ + 1) > kMostUnfolded)
      return refuse_mesh(text("%zu nodes with %zu instances of nodes may unfold to more than %zu", nodes_,
                              instances_, kMostUnfolded),
                         name_);
    return {};
  }

 private:
  Status look(std::string_view tag, MeshHeader& header) {
    if (tag.starts_with("?")) return {};
    const bool closes = tag.starts_with("/");
    const std::string_view element = Tokens(tag.substr(closes ? 1 : 0)).next();
    const std::string_view word = element.substr(0, element.find('/'));
    if (closes) {
      if (depth_ == 0) return refuse_mesh("an element ends that has not begun: " + files::shown(word), name_);
      --depth_;
      if (word == "library_nodes") in_library_ = false;
      return {};
    }
    if (!tag.ends_with("/")) {
      if (++depth_ > kMostDepth) return refuse_mesh("elements within elements, more than 64 deep", name_);
      if (word == "library_nodes") in_library_ = true;
    }
    if (word == "COLLADA") collada_ = true;
    if (word == "node") ++nodes_;
    if (word == "instance_node") {
      ++instances_;
      if (in_library_)
        return refuse_mesh("library_nodes has an instance_node, which may unfold without end", name_);
    }
    if (word == "up_axis" && !tag.ends_with("/")) {
      const std::string_view axis = Tokens(rest_.substr(0, std::min(rest_.find('<'), rest_.size()))).next();
      if (axis != "X_UP" && axis != "Y_UP" && axis != "Z_UP")
        return refuse_mesh("up_axis is " + files::shown(axis) + ", none of X_UP, Y_UP and Z_UP", name_);
      header.up_axis = axis.front();
    }
    if (!tag.ends_with("/"))
      if (auto ok = content_of(word); !ok) return ok;
    return numbers_of(tag, word, header.unit);
  }

  /// The numbers between a tag and the next: a word that is none holds assimp 5.2 in a loop that fills the
  /// memory.
  Status content_of(std::string_view element) {
    constexpr std::string_view kWhole[] = {"p", "v", "vcount", "h", "int_array"};
    constexpr std::string_view kReal[] = {"float_array", "matrix", "translate", "rotate",
                                          "scale",       "lookat", "skew"};
    const bool whole = std::find(std::begin(kWhole), std::end(kWhole), element) != std::end(kWhole);
    const bool real = std::find(std::begin(kReal), std::end(kReal), element) != std::end(kReal);
    if (!whole && !real) return {};
    const std::size_t end = std::min(rest_.find('<'), rest_.size());
    if (!rest_.substr(end).starts_with("</"))
      return refuse_mesh("something other than numbers in " + files::shown(element), name_);
    Tokens words(rest_.substr(0, end));
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      std::uint32_t index = 0;
      const bool digit = word.front() >= '0' && word.front() <= '9';
      if (whole ? !digit || !parse_number(word, index) || index > kMostIndex : !parse_finite(word))
        return refuse_mesh(files::shown(word) + " of " + files::shown(element) + " is no " +
                               (whole ? "index or count" : "finite number"),
                           name_);
    }
    return {};
  }

  Status numbers_of(std::string_view tag, std::string_view word, double& unit) {
    const struct {
      const char* attribute;
      std::size_t most;
    } bounds[] = {{"count", size_}, {"stride", 64}, {"offset", word == "input" ? kMostOffset : size_}};
    for (const auto& bound : bounds) {
      const auto value = attribute(tag, bound.attribute);
      std::size_t number = 0;
      if (value && (!parse_number(*value, number) || number > bound.most))
        return refuse_mesh(std::string(bound.attribute) + " of " + files::shown(word) + " is " +
                               files::shown(*value) + text(", more than %zu or no number", bound.most),
                           name_);
    }
    if (word != "unit") return {};
    if (const auto meter = attribute(tag, "meter");
        meter && (!parse_number(*meter, unit) || !(unit >= 1e-9 && unit <= 1e6)))
      return refuse_mesh("unit meter is " + files::shown(*meter) + ", outside [1e-9, 1e6]", name_);
    return {};
  }

  std::string_view rest_;
  std::size_t size_;
  const std::string& name_;
  std::size_t depth_ = 0, tags_ = 0, nodes_ = 0, instances_ = 0;
  bool in_library_ = false, collada_ = false;
};

}  // namespace

Status scan_dae(std::string_view bytes, const std::string& name, MeshHeader& header) {
  if (bytes.find('\0') != std::string_view::npos) return refuse_mesh("not text: it has a zero byte", name);
  header.up_axis = 'Y';  // where the file tells none
  return TagScan(bytes, name).run(header);
}

}  // namespace omniflight::planning
