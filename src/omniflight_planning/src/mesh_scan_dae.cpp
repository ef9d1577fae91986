// The tags of a COLLADA file: what a reader of XML could be made to unfold, or to read where nothing is.
#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "mesh_scan.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"
#include "text.hpp"
#include "tokens.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kMostDepth = 64, kMostTags = 1'000'000, kMostUnfolded = 100'000, kMostLists = 100'000;
constexpr std::uint32_t kMostIndex = 100'000'000;
constexpr std::size_t kMostOffset = 31;  // of an input: the numbers of a corner

constexpr std::string_view kSpace = " \t\r\n";

/// Of one tag, in its order.
class Attributes {
 public:
  /// `text`: the tag behind its name. False where an attribute is not NAME="VALUE": a value may have a > in
  /// it, and then a reader of XML sees another tag than this scan.
  bool read(std::string_view text) {
    all_.clear();
    while (true) {
      text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
      if (text.empty()) return true;
      const std::size_t equals = text.find('=');
      if (equals == std::string_view::npos) return false;
      std::string_view name = text.substr(0, equals);
      name = name.substr(0, name.find_last_not_of(kSpace) + 1);
      text.remove_prefix(equals + 1);
      text.remove_prefix(std::min(text.find_first_not_of(kSpace), text.size()));
      if (name.empty() || name.find_first_of(" \t\r\n\"'") != std::string_view::npos || text.empty() ||
          (text.front() != '"' && text.front() != '\''))
        return false;
      const std::size_t end = text.find(text.front(), 1);
      if (end == std::string_view::npos) return false;
      all_.emplace_back(name, text.substr(1, end - 1));
      text.remove_prefix(end + 1);
    }
  }
  std::optional<std::string_view> operator[](std::string_view name) const {
    for (const auto& [key, value] : all_)
      if (key == name) return value;
    return std::nullopt;
  }

 private:
  std::vector<std::pair<std::string_view, std::string_view>> all_;
};

/// What a list of numbers is read through: `count` times some of `stride` numbers, from number `offset` on.
struct Accessor {
  std::string_view array;
  std::size_t count = 0, stride = 1, offset = 0, parameters = 0;
  std::size_t needs() const {
    return count == 0 ? 0 : offset + (count - 1) * stride + std::max<std::size_t>(1, parameters);
  }
};

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
    return check_accessors();
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
      if (word == "accessor") in_accessor_ = false;
      return {};
    }
    const std::string_view behind = tag.substr(std::min(tag.size(), tag.find(word) + word.size()));
    if (!attributes_.read(behind.substr(0, behind.size() - tag.ends_with("/"))))
      return refuse_mesh("an attribute of " + files::shown(word) + " is not NAME=\"VALUE\" without >", name_);
    // assimp 5.2 reads their numbers without looking how many there are; a map does not move
    if (word == "animation" || word == "controller" || word == "Name_array" || word == "IDREF_array")
      return refuse_mesh("it has " + files::shown(word) + ": animations and skins are not read", name_);
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
    numbers_ = 0;
    if (!tag.ends_with("/"))
      if (auto ok = content_of(word); !ok) return ok;
    if (auto ok = numbers_of(word, header.unit); !ok) return ok;
    return lists_of(word, tag.ends_with("/"));
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
      ++numbers_;
    }
    return {};
  }

  Status numbers_of(std::string_view word, double& unit) {
    const struct {
      const char* attribute;
      std::size_t most;
    } bounds[] = {{"count", size_}, {"stride", 64}, {"offset", word == "input" ? kMostOffset : size_}};
    for (const auto& bound : bounds) {
      const auto value = attributes_[bound.attribute];
      std::size_t number = 0;
      if (value && (!parse_number(*value, number) || number > bound.most))
        return refuse_mesh(std::string(bound.attribute) + " of " + files::shown(word) + " is " +
                               files::shown(*value) + text(", more than %zu or no number", bound.most),
                           name_);
    }
    if (word != "unit") return {};
    if (const auto meter = attributes_["meter"];
        meter && (!parse_number(*meter, unit) || !(unit >= 1e-9 && unit <= 1e6)))
      return refuse_mesh("unit meter is " + files::shown(*meter) + ", outside [1e-9, 1e6]", name_);
    return {};
  }

  /// Remembers lists of numbers and what is read of them. assimp 5.2 believes the counts that both tell, and
  /// takes any number where one is missing.
  Status lists_of(std::string_view word, bool empty) {
    constexpr std::string_view kCounted[] = {"float_array", "int_array", "accessor", "triangles",
                                             "polylist",    "polygons",  "trifans",  "tristrips",
                                             "lines",       "linestrips"};
    if (word == "param" && in_accessor_) ++accessors_.back().parameters;
    if (std::find(std::begin(kCounted), std::end(kCounted), word) == std::end(kCounted)) return {};
    std::size_t count = 0;
    if (const auto told = attributes_["count"]; !told || !parse_number(*told, count))
      return refuse_mesh("count of " + files::shown(word) + " is missing", name_);
    const bool array = word.ends_with("_array");
    if (!array && word != "accessor") return {};
    if (accessors_.size() + arrays_.size() >= kMostLists)
      return refuse_mesh(text("more than %zu lists of numbers", kMostLists), name_);
    const std::string_view id = attributes_[array ? "id" : "source"].value_or("");
    if (id.find_first_of("& \t\r\n") != std::string_view::npos)
      return refuse_mesh(
          "the name " + files::shown(id) + " has a space or a character that is written as another", name_);
    if (array) {
      if (count != numbers_)
        return refuse_mesh(text("%zu numbers where count tells %zu: ", numbers_, count) + files::shown(word),
                           name_);
      // of several of one name whichever is shortest: who knows which one is taken
      const auto [at, is_new] = arrays_.try_emplace(id, count);
      at->second = std::min(at->second, count);
      return {};
    }
    Accessor accessor{.array = id.substr(std::min<std::size_t>(id.size(), id.starts_with("#"))),
                      .count = count};
    if (const auto told = attributes_["stride"]) (void)parse_number(*told, accessor.stride);
    if (const auto told = attributes_["offset"]) (void)parse_number(*told, accessor.offset);
    accessors_.push_back(accessor);
    in_accessor_ = !empty;
    return {};
  }

  Status check_accessors() const {
    for (const Accessor& accessor : accessors_) {
      const auto array = arrays_.find(accessor.array);
      const std::size_t there = array == arrays_.end() ? 0 : array->second;
      if (accessor.needs() > there)
        return refuse_mesh(
            text("an accessor reads %zu numbers where there are %zu: ", accessor.needs(), there) +
                files::shown(accessor.array),
            name_);
    }
    return {};
  }

  std::string_view rest_;
  std::size_t size_;
  const std::string& name_;
  Attributes attributes_;
  std::map<std::string_view, std::size_t> arrays_;  ///< numbers of each, by its id
  std::vector<Accessor> accessors_;
  std::size_t depth_ = 0, tags_ = 0, nodes_ = 0, instances_ = 0, numbers_ = 0;
  bool in_library_ = false, in_accessor_ = false, collada_ = false;
};

}  // namespace

Status scan_dae(std::string_view bytes, const std::string& name, MeshHeader& header) {
  // XML has none of them, and a form feed among numbers holds assimp 5.2 in a loop that fills the memory
  if (std::any_of(bytes.begin(), bytes.end(),
                  [](char c) { return c >= 0 && c < ' ' && c != '\t' && c != '\r' && c != '\n'; }))
    return refuse_mesh("not XML: it has a control character", name);
  header.up_axis = 'Y';  // where the file tells none
  return TagScan(bytes, name).run(header);
}

}  // namespace omniflight::planning
