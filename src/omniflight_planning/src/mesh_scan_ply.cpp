// The header of a .ply file, and its elements against it.
#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "mesh_scan.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/mesh.hpp"
#include "text.hpp"
#include "tokens.hpp"

namespace omniflight::planning {
namespace {

constexpr std::size_t kMostProperties = 64, kMostElements = 16;
constexpr std::uint64_t kMostCornersOfFace = 1000;
enum class Body { ascii, little, big };

struct Property {
  std::string_view name;
  std::size_t bytes = 0, count_bytes = 0;  // count_bytes: 0 unless it is a list
  bool is_float = false;
};
struct Element {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};
struct Header {
  Body body = Body::ascii;
  std::vector<Element> elements;
  std::string_view rest;  // after end_header
};

std::size_t size_of(std::string_view type, bool& is_float) {
  is_float = type == "float" || type == "float32" || type == "double" || type == "float64";
  for (const char* name : {"char", "uchar", "int8", "uint8"})
    if (type == name) return 1;
  for (const char* name : {"short", "ushort", "int16", "uint16"})
    if (type == name) return 2;
  for (const char* name : {"int", "uint", "int32", "uint32", "float", "float32"})
    if (type == name) return 4;
  return type == "double" || type == "float64" ? 8 : 0;
}

Status read_property(Tokens words, const std::string& where, Element& element) {
  Property p;
  std::string_view type = words.next();
  bool count_is_float = false;
  if (type == "list") {
    p.count_bytes = size_of(words.next(), count_is_float);
    if (p.count_bytes == 0 || count_is_float)
      return refuse_mesh("a list whose count has no whole type", where);
    type = words.next();
  }
  p.bytes = size_of(type, p.is_float);
  p.name = words.next();
  if (p.bytes == 0 || p.name.empty()) return refuse_mesh("a property of an unknown type", where);
  if (element.properties.size() >= kMostProperties) return refuse_mesh("more than 64 properties", where);
  element.properties.push_back(p);
  return {};
}

Result<Header> read_header(std::string_view bytes, const std::string& name) {
  Header out;
  Lines lines(bytes);
  std::string_view line;
  bool format = false;
  while (lines.next(line)) {
    const std::string where = name + ":" + std::to_string(lines.number());
    Tokens words(line);
    const std::string_view key = words.next();
    if (lines.number() == 1) {
      if (key != "ply") return refuse_mesh("not a .ply file: the first line is " + files::shown(line), where);
    } else if (key == "format") {
      const std::string_view kind = words.next();
      format = true;
      if (kind == "ascii")
        out.body = Body::ascii;
      else if (kind == "binary_little_endian")
        out.body = Body::little;
      else if (kind == "binary_big_endian")
        out.body = Body::big;
      else
        return refuse_mesh("format " + files::shown(kind) + " is unknown", where);
    } else if (key == "element") {
      Element e;
      e.name = words.next();
      if (!parse_number(words.next(), e.count) || e.count > bytes.size())
        return refuse_mesh(
            "element " + files::shown(e.name) + " has no count, or one of more than the file has bytes",
            where);
      if (out.elements.size() >= kMostElements) return refuse_mesh("more than 16 kinds of elements", where);
      out.elements.push_back(std::move(e));
    } else if (key == "property" && !out.elements.empty()) {
      if (auto ok = read_property(words, where, out.elements.back()); !ok) return Failure(ok.error());
    } else if (key == "end_header") {
      if (!format) return refuse_mesh("the header tells no format", where);
      out.rest = lines.rest();
      return out;
    } else if (key != "comment" && key != "obj_info") {
      return refuse_mesh("the header has an unknown line " + files::shown(line), where);
    }
  }
  return refuse_mesh("the header has no end_header", name);
}

/// One value after another; a whole number where it is one.
class Values {
 public:
  Values(const Header& header) : body_(header.body), rest_(header.rest), lines_(header.rest), words_("") {}
  /// Before and behind the values of an element: as text it has one line, which is what assimp takes for it.
  bool begins() {
    std::string_view line;
    if (body_ != Body::ascii) return true;
    if (!lines_.next(line) || line.find_first_of(kLineEnds) != std::string_view::npos) return false;
    words_ = Tokens(line);
    return true;
  }
  bool ends() { return body_ != Body::ascii || words_.next().empty(); }
  bool take(std::size_t bytes, bool is_float, std::uint64_t& whole) {
    whole = ~std::uint64_t{0};
    if (body_ == Body::ascii) {
      const std::string_view word = words_.next();
      return is_float ? parse_finite(word) : parse_finite(word) && (parse_number(word, whole) || true);
    }
    if (rest_.size() < bytes) return false;
    if (!is_float) {
      whole = 0;
      for (std::size_t i = 0; i < bytes; ++i) {
        const std::size_t at = body_ == Body::little ? bytes - 1 - i : i;
        whole = whole << 8 | static_cast<unsigned char>(rest_[at]);
      }
    }
    rest_.remove_prefix(bytes);
    return true;
  }

 private:
  static constexpr std::string_view kLineEnds{"\r\f\v\0", 4};  // of somebody, if not of Lines
  Body body_;
  std::string_view rest_;
  Lines lines_;
  Tokens words_;
};

}  // namespace

Status scan_ply(std::string_view bytes, const std::string& name) {
  const auto header = read_header(bytes, name);
  if (!header) return Failure(header.error());
  Values values(*header);
  std::uint64_t vertices = 0, triangles = 0, number = 0;
  for (const Element& element : header->elements) {
    if (element.name == "vertex") vertices = element.count;
    if (element.properties.empty() && element.count > 0)
      return refuse_mesh("element " + files::shown(element.name) + " has no properties", name);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      const auto not_one_line = [&] {
        return refuse_mesh(
            text("%s %llu does not have a line of its own", std::string(element.name.substr(0, 40)).c_str(),
                 static_cast<unsigned long long>(i)),
            name);
      };
      if (!values.begins()) return not_one_line();
      for (const Property& p : element.properties) {
        const auto ends = [&] {
          return refuse_mesh(text("%s %llu lacks a finite ", std::string(element.name.substr(0, 40)).c_str(),
                                  static_cast<unsigned long long>(i)) +
                                 files::shown(p.name) + ", or the file ends there",
                             name);
        };
        std::uint64_t count = 1;
        if (p.count_bytes > 0 && (!values.take(p.count_bytes, false, count) || count > bytes.size()))
          return ends();
        const bool indices = p.name == "vertex_indices" || p.name == "vertex_index";
        if (indices && (count < 3 || count > kMostCornersOfFace))
          return refuse_mesh(text("face %llu has fewer than 3 or more than 1000 corners",
                                  static_cast<unsigned long long>(i)),
                             name);
        for (std::uint64_t k = 0; k < count; ++k) {
          if (!values.take(p.bytes, p.is_float, number)) return ends();
          if (indices && number >= vertices)
            return refuse_mesh(
                text("face %llu points outside of the %llu vertices before it",
                     static_cast<unsigned long long>(i), static_cast<unsigned long long>(vertices)),
                name);
        }
        if (indices) triangles += count - 2;
        if (triangles > kMaxMeshTriangles)
          return refuse_mesh(text("more than %zu triangles", kMaxMeshTriangles), name);
      }
      if (!values.ends()) return not_one_line();
    }
  }
  return triangles == 0 ? Status(refuse_mesh("the file has no face", name)) : Status{};
}

}  // namespace omniflight::planning
