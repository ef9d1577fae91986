#include "yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>

#include "omniflight_files/files.hpp"

namespace omniflight::files {
namespace {

constexpr std::size_t kMaxDepth = 64;

/// Thrown through yaml-cpp by our handler and caught below; it never leaves this file.
struct Refused {
  int line;
  std::string what, next_step;
};

bool valid_utf8(std::string_view s, int& line) {
  line = 1;
  for (std::size_t i = 0; i < s.size();) {
    const unsigned char c = static_cast<unsigned char>(s[i]);
    if (c == '\n') ++line;
    const std::size_t extra = c < 0x80 ? 0 : (c >> 5) == 6 ? 1 : (c >> 4) == 14 ? 2 : (c >> 3) == 30 ? 3 : 9;
    if (extra == 9 || c == 0xc0 || c == 0xc1 || c > 0xf4 || i + extra >= s.size()) return false;
    for (std::size_t k = 1; k <= extra; ++k)
      if ((static_cast<unsigned char>(s[i + k]) & 0xc0) != 0x80) return false;
    if ((c < 0x20 && c != '\n' && c != '\r' && c != '\t') || c == 0x7f) return false;
    i += extra + 1;
  }
  return true;
}

class Builder : public YAML::EventHandler {
 public:
  explicit Builder(YamlState& state) : state_(state) {}
  int root = -1;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    add(mark, YamlNode::Kind::null);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { refuse_anchor(mark, 1); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    Open* top = stack_.empty() ? nullptr : &stack_.back();
    if (top && top->is_map && !top->has_key) {
      if (top->keys.size() >= 10000) throw Refused{mark.line + 1, "map has more than 10000 keys", ""};
      if (!top->keys.insert(value).second)
        throw Refused{mark.line + 1, "key " + shown(value) + " appears twice", "Keep one of the two"};
      state_.nodes[static_cast<std::size_t>(top->node)].keys.push_back(value);
      top->has_key = true;
      return;
    }
    const int node = add(mark, YamlNode::Kind::scalar);
    state_.nodes[static_cast<std::size_t>(node)].text = value;
    state_.nodes[static_cast<std::size_t>(node)].quoted = tag == "!";
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, false);
  }
  void OnSequenceEnd() override { stack_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag, anchor, true);
  }
  void OnMapEnd() override { stack_.pop_back(); }

 private:
  struct Open {
    int node;
    bool is_map;
    bool has_key = false;
    std::set<std::string> keys = {};
  };

  static void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor) throw Refused{mark.line + 1, "anchors and aliases are not allowed", "Write the value out"};
  }
  static void refuse_tag(const YAML::Mark& mark, const std::string& tag) {
    if (!tag.empty() && tag != "?" && tag != "!")
      throw Refused{mark.line + 1, "tag " + shown(tag) + " is not allowed", "Remove the tag"};
  }
  int add(const YAML::Mark& mark, YamlNode::Kind kind) {
    const int index = static_cast<int>(state_.nodes.size());
    if (state_.nodes.size() >= 200000)
      throw Refused{mark.line + 1, "document has more than 200000 values", ""};
    YamlNode node;
    node.kind = kind;
    node.line = mark.line + 1;
    state_.nodes.push_back(std::move(node));
    if (stack_.empty()) {
      root = index;
      return index;
    }
    Open& top = stack_.back();
    if (top.is_map && !top.has_key)
      throw Refused{mark.line + 1, "a key must be plain text", "Use a word as the key"};
    top.has_key = false;
    state_.nodes[static_cast<std::size_t>(top.node)].children.push_back(index);
    return index;
  }
  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, bool is_map) {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    if (stack_.size() >= kMaxDepth)
      throw Refused{mark.line + 1, "nesting is deeper than 64 levels", "Flatten the document"};
    const int node = add(mark, is_map ? YamlNode::Kind::map : YamlNode::Kind::sequence);
    stack_.push_back({node, is_map});
  }

  YamlState& state_;
  std::vector<Open> stack_;
};

/// yaml-cpp tokenises a whole flow collection before the first event; so bound the brackets beforehand.
bool too_many_open_brackets(std::string_view text) {
  int open = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') ++open;
    if ((c == ']' || c == '}') && open > 0) --open;
    if (open > 1000) return true;
  }
  return false;
}

}  // namespace

Result<int> parse_yaml(std::string_view text, YamlState& state) {
  const auto at = [&](int line) { return state.file + ":" + std::to_string(line); };
  if (text.size() > kMegabyte)
    return bad_input("has " + std::to_string(text.size()) + " bytes, a YAML file may have 1 MB", state.file,
                     "Split it");
  int line = 0;
  if (!valid_utf8(text, line))
    return bad_input("is not valid UTF-8 text", at(line), "Save the file as UTF-8");
  if (too_many_open_brackets(text))
    return bad_input("nesting is deeper than 64 levels", state.file, "Flatten the document");
  try {
    std::istringstream stream{std::string(text)};
    YAML::Parser parser(stream);
    Builder builder(state);
    if (!parser.HandleNextDocument(builder) || builder.root < 0)
      return bad_input("is empty", state.file, "Write at least one key");
    const int root = builder.root;
    Builder second(state);
    if (parser.HandleNextDocument(second))
      return bad_input("contains more than one document", state.file, "Remove everything after '---'");
    return root;
  } catch (const Refused& refused) {
    return bad_input(refused.what, at(refused.line), refused.next_step);
  } catch (const YAML::Exception& e) {
    return bad_input("is not valid YAML (" + e.msg + ")", at(e.mark.line + 1), "Correct the syntax");
  } catch (const std::exception& e) {
    return bad_input(std::string("cannot be parsed (") + e.what() + ")", state.file);
  }
}

}  // namespace omniflight::files
