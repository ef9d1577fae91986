#include "omniflight_proof/world.hpp"

#include <cmath>
#include <sstream>

#include "fields.hpp"

namespace omniflight::proof {
namespace {

template <class E>
using Choices = std::initializer_list<std::pair<const char*, E>>;

/// Fills a world from YAML; what is absent keeps its default.
struct Reader {
  files::YamlReader yaml;

  void number(const char* key, double& x, double low, double high, const char* unit) {
    x = yaml.number(key, files::between(low, high, unit), x);
  }
  void integer(const char* key, int& x, int low, int high) {
    x = static_cast<int>(yaml.integer(key, low, high, x));
  }
  void flag(const char* key, bool& x) { x = yaml.boolean(key, x); }
  void text(const char* key, std::string& x) { x = yaml.string(key, x); }
  void vec3(const char* key, Vec3& x, double low, double high, const char* unit) {
    x = yaml.vec3(key, files::between(low, high, unit), x);
  }
  void angle(const char* key, double& x, double low, double high) {
    x = to_radians(yaml.number(key, files::between(low, high, "deg"), to_degrees(x)));
  }
  void angles(const char* key, Vec3& x, double low, double high) {
    x = yaml.vec3(key, files::between(low, high, "deg"), x * (180.0 / kPi)) * (kPi / 180.0);
  }
  template <class E>
  void choice(const char* key, E& x, Choices<E> choices) {
    x = yaml.choice<E>(key, choices, x);
  }
  template <class T>
  void part(const char* key, T& x) {
    if (auto child = yaml.optional_child(key)) {
      Reader r{*child};
      visit(r, x);
    }
  }
  template <class T>
  void optional(const char* key, std::optional<T>& x) {
    if (!yaml.has(key)) return;
    x.emplace();
    part(key, *x);
  }
  template <class T>
  void list(const char* key, std::vector<T>& x, std::size_t most) {
    for (const files::YamlReader& item : yaml.children(key, 0, most)) {
      Reader r{item};
      visit(r, x.emplace_back());
    }
  }
};

/// Keeps the first field of a world that is out of its bounds.
struct Checker {
  std::string path;
  Error error;
  bool failed = false;

  void refuse(const char* key, double x, double low, double high, const char* unit) {
    if (failed) return;
    failed = true;
    std::ostringstream message;
    message << "is " << x << ' ' << unit << ", outside [" << low << ", " << high << "] " << unit;
    error = {ErrorCode::bad_input, message.str(), path + key, ""};
  }
  void number(const char* key, double x, double low, double high, const char* unit) {
    if (!(x >= low && x <= high)) refuse(key, x, low, high, unit);
  }
  void integer(const char* key, int x, int low, int high) { number(key, x, low, high, ""); }
  void flag(const char*, bool) {}
  void text(const char*, const std::string&) {}
  void vec3(const char* key, const Vec3& x, double low, double high, const char* unit) {
    for (int k = 0; k < 3; ++k) number(key, x[k], low, high, unit);
  }
  void angle(const char* key, double x, double low, double high) {
    number(key, to_degrees(x), low - 1e-9, high + 1e-9, "deg");
  }
  void angles(const char* key, const Vec3& x, double low, double high) {
    for (int k = 0; k < 3; ++k) angle(key, x[k], low, high);
  }
  template <class E>
  void choice(const char*, E, Choices<E>) {}
  template <class T>
  void part(const std::string& key, T& x) {
    const std::string before = path;
    path += key + ".";
    visit(*this, x);
    path = before;
  }
  template <class T>
  void optional(const char* key, std::optional<T>& x) {
    if (x) part(key, *x);
  }
  template <class T>
  void list(const char* key, std::vector<T>& x, std::size_t most) {
    if (x.size() > most) refuse(key, static_cast<double>(x.size()), 0, static_cast<double>(most), "entries");
    for (std::size_t i = 0; i < x.size(); ++i) part(key + ("[" + std::to_string(i) + "]"), x[i]);
  }
};

/// What no range of a single field can say.
Status check_together(const World& w) {
  const auto refuse = [](const char* what, const char* where, const char* next) -> Status {
    return bad_input(what, where, next);
  };
  if (w.wind && !w.airframe && !w.blades && !(w.cable && w.cable->drag_coefficient > 0))
    return refuse("blows on nothing", "wind", "Give airframe, blades or cable.drag_coefficient as well");
  if (w.cable && w.overhead_rope && w.cable->links + w.overhead_rope->links > 64)
    return refuse("have more than 64 links together", "cable.links, overhead_rope.links", "Take fewer");
  for (const Law& l : w.laws)
    if (!(l.axis.norm() > 1e-6) || !(l.wave_W.norm() > 1e-6))
      return refuse("is a vector without direction", "laws.axis", "Give one of unit length");
  return {};
}

}  // namespace

Status validate(const World& world) {
  World copy = world;
  Checker checker;
  visit(checker, copy);
  if (checker.failed) return Failure(checker.error);
  return check_together(world);
}

Result<World> read_world(files::YamlReader yaml) {
  if (yaml.string("schema") != "omniflight.proof_world/1")
    yaml.error_at("schema", "is not omniflight.proof_world/1");
  World world;
  Reader reader{yaml};
  visit(reader, world);
  if (auto ok = yaml.finish(); !ok) return Failure(ok.error());
  if (auto ok = check_together(world); !ok)
    return bad_input(ok.error().message, yaml.file() + ": " + ok.error().where, ok.error().next_step);
  return world;
}

Result<World> load_world(const std::filesystem::path& path) {
  auto yaml = files::YamlReader::load(path);
  if (!yaml) return Failure(yaml.error());
  return read_world(*yaml);
}

}  // namespace omniflight::proof
