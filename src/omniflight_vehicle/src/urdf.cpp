#include "urdf.hpp"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <functional>
#include <mutex>

namespace omniflight::vehicle {
namespace {

/// Collects what urdfdom reports through console_bridge: an "Error" line is the only sign of a dropped
/// inertial.
class Collector final : public console_bridge::OutputHandler {
 public:
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first_.empty()) first_ = text;
  }
  std::string first_;
};

/// Where the tag that starts at `from` ends: the '>' outside quotes; npos when there is none.
std::size_t tag_end(const std::string& text, std::size_t from) {
  char quote = 0;
  for (std::size_t i = from; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != 0)
      quote = c == quote ? char{0} : quote;
    else if (c == '"' || c == '\'')
      quote = c;
    else if (c == '>')
      return i;
  }
  return std::string::npos;
}

/// Linear scan before the recursive parser: depth and number of links. It must never see fewer open elements
/// than that parser, so whatever the two could read differently is refused.
Status pre_scan(const std::string& text, const std::string& name) {
  int depth = 0, links = 0;
  bool begun = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '<') continue;
    if (text.compare(i, 4, "<!--") == 0) {
      const auto end = text.find("-->", i + 4);
      if (end == std::string::npos) return bad_input("a comment does not end", name);
      i = end + 2;
      continue;
    }
    if (text.compare(i, 2, "<!") == 0) return bad_input("DOCTYPE, ENTITY and CDATA are refused", name);
    const bool declaration = text.compare(i, 2, "<?") == 0, closing = text.compare(i, 2, "</") == 0;
    if (declaration && begun) return bad_input("an XML declaration may only come first", name);
    begun = true;
    const char first = i + 1 < text.size() ? text[i + 1] : ' ';
    const bool letter = (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z') || first == '_';
    if (!declaration && !closing && !letter) return bad_input("a tag does not begin with a letter", name);
    const auto end = declaration || closing ? text.find('>', i) : tag_end(text, i);
    if (end == std::string::npos) return bad_input("a tag does not end", name);
    if (closing && --depth < 0) return bad_input("tags are not balanced", name, "Close what was opened");
    if (!closing && !declaration) {
      if (text.compare(i, 5, "<link") == 0) ++links;
      if (text[end - 1] != '/' && ++depth > 64) return bad_input("elements are nested deeper than 64", name);
    }
    i = end;
  }
  if (depth != 0) return bad_input("tags are not balanced", name, "The file may be truncated");
  if (links > 1000) return bad_input("more than 1000 links", name);
  return {};
}

/// urdfdom's links own each other along joints, so a cycle of joints would never be freed.
class OwnershipCut {
 public:
  explicit OwnershipCut(const urdf::ModelInterfaceSharedPtr& model) : model_(model) {}
  ~OwnershipCut() {
    if (!model_) return;
    for (auto& [name, link] : model_->links_) {
      link->child_links.clear();
      link->child_joints.clear();
    }
  }
  OwnershipCut(const OwnershipCut&) = delete;
  OwnershipCut& operator=(const OwnershipCut&) = delete;

 private:
  const urdf::ModelInterfaceSharedPtr& model_;
};

Vec3 to_vec(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Quat to_quat(const urdf::Rotation& r) { return Quat(r.w, r.x, r.y, r.z); }

}  // namespace

Result<UrdfBody> read_urdf(const std::string& text, const std::string& name) {
  if (auto ok = pre_scan(text, name); !ok) return Failure(ok.error());
  urdf::ModelInterfaceSharedPtr model;
  const OwnershipCut cut(model);
  Collector collector;
  {
    static std::mutex mutex;  // console_bridge's handler is global
    const std::lock_guard lock(mutex);
    console_bridge::useOutputHandler(&collector);
    model = urdf::parseURDF(text);
    console_bridge::restorePreviousOutputHandler();
  }
  if (!collector.first_.empty() || !model)
    return bad_input(collector.first_.empty() ? "is not a URDF" : collector.first_, name, "Correct the URDF");
  const auto root = model->getRoot();
  if (!root) return bad_input("has no root link", name);

  struct Part {
    double mass;
    Vec3 p;
    Mat3 inertia;
  };
  UrdfBody body;
  std::vector<Part> parts;
  std::size_t visited = 0;
  std::string problem;
  const std::function<void(const urdf::LinkConstSharedPtr&, const Vec3&, const Quat&, int)> walk =
      [&](const urdf::LinkConstSharedPtr& link, const Vec3& p, const Quat& q, int depth) {
        if (++visited > model->links_.size() || depth > 64) {
          problem = "links form a cycle or a chain longer than 64";
          return;
        }
        if (link->inertial) {
          const auto& in = *link->inertial;
          if (!(in.mass > 0) || !std::isfinite(in.mass))
            problem = "link '" + link->name + "': mass must be a positive number of kg";
          Mat3 J;
          J << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
          const Mat3 R = (q * to_quat(in.origin.rotation)).toRotationMatrix();
          parts.push_back({in.mass, p + q * to_vec(in.origin.position), R * J * R.transpose()});
        }
        for (const auto& c : link->collision_array) {
          if (!c->geometry) continue;
          CollisionShape shape;
          shape.p_BS = p + q * to_vec(c->origin.position);
          shape.q_BS = q * to_quat(c->origin.rotation);
          if (const auto* s = dynamic_cast<const urdf::Sphere*>(c->geometry.get())) {
            shape.size = Vec3::Constant(s->radius);
          } else if (const auto* y = dynamic_cast<const urdf::Cylinder*>(c->geometry.get())) {
            shape.kind = CollisionShape::Kind::cylinder;
            shape.size = {y->radius, y->length, 0};
          } else if (const auto* b = dynamic_cast<const urdf::Box*>(c->geometry.get())) {
            shape.kind = CollisionShape::Kind::box;
            shape.size = to_vec(b->dim);
          } else {
            problem = "link '" + link->name +
                      "': mesh collision geometry is not supported; give box, cylinder or sphere";
          }
          if (!shape.size.allFinite() || shape.size.minCoeff() < 0)
            problem = "link '" + link->name + "': collision size must be positive (m)";
          body.collision.push_back(shape);
        }
        for (const auto& joint : link->child_joints) {
          const auto child = model->getLink(joint->child_link_name);
          if (!child) continue;
          const auto& t = joint->parent_to_joint_origin_transform;
          walk(child, p + q * to_vec(t.position), q * to_quat(t.rotation), depth + 1);
        }
      };
  walk(root, Vec3::Zero(), Quat::Identity(), 0);
  if (problem.empty() && visited != model->links_.size())
    problem = "not every link is reachable from the root";
  if (problem.empty() && parts.empty()) problem = "no link has an inertial";
  if (!problem.empty()) return bad_input(problem, name, "Correct the URDF");

  for (const Part& part : parts) {
    body.mass += part.mass;
    body.center_of_mass += part.mass * part.p;
  }
  body.center_of_mass /= body.mass;
  for (const Part& part : parts) {
    const Mat3 d = skew(part.p - body.center_of_mass);
    body.inertia += part.inertia - part.mass * d * d;
  }
  return body;
}

}  // namespace omniflight::vehicle
