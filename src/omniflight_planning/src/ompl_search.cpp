#include "ompl_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include <ompl/base/MotionValidator.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/spaces/SE3StateSpace.h>
#include <ompl/datastructures/NearestNeighborsLinear.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/est/EST.h>
#include <ompl/geometric/planners/informedtrees/ABITstar.h>
#include <ompl/geometric/planners/informedtrees/AITstar.h>
#include <ompl/geometric/planners/informedtrees/BITstar.h>
#include <ompl/geometric/planners/kpiece/BKPIECE1.h>
#include <ompl/geometric/planners/kpiece/KPIECE1.h>
#include <ompl/geometric/planners/rrt/InformedRRTstar.h>
#include <ompl/geometric/planners/rrt/RRT.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>

#include "omniflight_core/random.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_planning/planner.hpp"

namespace ob = ompl::base;
namespace og = ompl::geometric;

namespace omniflight::planning {
namespace {

using Space = ob::SE3StateSpace;

Pose read(const ob::State* state) {
  const auto* s = state->as<Space::StateType>();
  const auto& q = s->rotation();
  return {Vec3(s->getX(), s->getY(), s->getZ()), Quat(q.w, q.x, q.y, q.z).normalized()};
}

void write(const Pose& pose, ob::State* state) {
  auto* s = state->as<Space::StateType>();
  s->setXYZ(pose.p_WB.x(), pose.p_WB.y(), pose.p_WB.z());
  s->rotation().w = pose.q_WB.w();
  s->rotation().x = pose.q_WB.x();
  s->rotation().y = pose.q_WB.y();
  s->rotation().z = pose.q_WB.z();
}

/// The box that the body's origin may be in.
std::pair<Vec3, Vec3> box_of(const StateCheck& check) {
  if (const auto& space = check.space()) return {space->lower, space->upper};
  return {check.map().lower(), check.map().upper()};
}

class Validator : public ob::MotionValidator {
 public:
  Validator(const ob::SpaceInformationPtr& si, const StateCheck& check)
      : ob::MotionValidator(si), check_(check) {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    return check_.motion_valid(read(a), read(b));
  }
  bool checkMotion(const ob::State* a, const ob::State* b,
                   std::pair<ob::State*, double>& last) const override {
    last.second = 0.0;
    return checkMotion(a, b);
  }

 private:
  const StateCheck& check_;
};

/// Positions uniform in the map; attitudes mostly between start and goal, else uniform: a mission that keeps
/// its attitude should not tumble on the way. Those of rigid bodies are uniform.
class Sampler : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, const StateCheck& check, const Pose& start, const Pose& goal,
          Random* random)
      : ob::StateSampler(space), check_(check), start_(start), goal_(goal), random_(*random) {}

  void sampleUniform(ob::State* state) override {
    Pose pose;
    const auto [low, high] = box_of(check_);
    for (int k = 0; k < 3; ++k) pose.p_WB[k] = random_.uniform(low[k], high[k]);
    if (!check_.space() && random_.uniform() < 0.75) {
      pose.q_WB = start_.q_WB.slerp(random_.uniform(), goal_.q_WB).normalized();
    } else {
      pose.q_WB = uniform_attitude();
    }
    write(pose, state);
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    perturb(state, near, [&] { return random_.uniform(-distance, distance); });
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    perturb(state, mean, [&] { return deviation * random_.normal(); });
  }

 private:
  template <class Draw>
  void perturb(ob::State* state, const ob::State* around, Draw draw) {
    Pose pose = read(around);
    for (int k = 0; k < 3; ++k) pose.p_WB[k] += draw();
    const Vec3 turn(draw(), draw(), draw());
    pose.q_WB = (pose.q_WB * exp_rotation(turn)).normalized();
    write(pose, state);
    space_->enforceBounds(state);
  }
  Quat uniform_attitude() {
    Eigen::Vector4d v;
    do {
      for (int k = 0; k < 4; ++k) v[k] = random_.normal();
    } while (v.norm() < 1e-6);
    return Quat(v[0], v[1], v[2], v[3]).normalized();
  }

  const StateCheck& check_;
  Pose start_, goal_;
  Random& random_;
};

using Made = std::shared_ptr<ob::Planner>;

template <class Planner>
Made stock(const ob::SpaceInformationPtr& si) {
  return std::make_shared<Planner>(si);
}

/// The nearest of all in SE(3), the first of equals, as NearestNeighborsLinear finds it. The distance of most
/// is bounded from below without its arc cosine: |dp| alone, then with the chord 2 sin(angle / 2) <= angle.
template <class Motion>
class NearestPoses final : public ompl::NearestNeighborsLinear<Motion> {
 public:
  using Base = ompl::NearestNeighborsLinear<Motion>;
  void add(const Motion& motion) override {
    Base::add(motion);
    keep(motion);
  }
  void add(const std::vector<Motion>& motions) override {
    Base::add(motions);
    for (const Motion& motion : motions) keep(motion);
  }
  bool remove(const Motion& motion) override {
    if (!Base::remove(motion)) return false;
    rows_.clear();
    for (const Motion& left : this->data_) keep(left);
    return true;
  }
  void clear() override {
    Base::clear();
    rows_.clear();
  }
  Motion nearest(const Motion& to) const override {
    constexpr double kSame = 1e-9;       // OMPL takes angles of such cosines for none
    constexpr double kRounding = 1e-12;  // relative, of the bounds
    const Row at = row(to);
    double best = HUGE_VAL;
    std::size_t found = rows_.size();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Row& r = rows_[i];
      const double x = r.p[0] - at.p[0], y = r.p[1] - at.p[1], z = r.p[2] - at.p[2];
      const double square = x * x + y * y + z * z, limit = best * (1.0 + kRounding);
      if (square > limit * limit) continue;
      const double cosine =
          std::abs(r.q[0] * at.q[0] + r.q[1] * at.q[1] + r.q[2] * at.q[2] + r.q[3] * at.q[3]);
      if (cosine < 1.0 - 2.0 * kSame && std::sqrt(square) + std::sqrt(2.0 * (1.0 - cosine)) > limit) continue;
      const double distance = this->distFun_(this->data_[i], to);
      if (found < rows_.size() && distance >= best) continue;
      best = distance;
      found = i;
    }
    if (found == rows_.size()) throw ompl::Exception("no poses to be nearest to");
    return this->data_[found];
  }

 private:
  struct Row {
    double p[3], q[4];  // m; x y z w
  };
  static Row row(const Motion& motion) {
    const auto* s = motion->state->template as<Space::StateType>();
    const auto& q = s->rotation();
    return {{s->getX(), s->getY(), s->getZ()}, {q.x, q.y, q.z, q.w}};
  }
  void keep(const Motion& motion) { rows_.push_back(row(motion)); }

  std::vector<Row> rows_;
};

Made rrtconnect(const ob::SpaceInformationPtr& si) {
  auto out = std::make_shared<og::RRTConnect>(si);
  out->setNearestNeighbors<NearestPoses>();  // exact, so that runs repeat
  out->setRange(1.0);
  return out;
}

/// A planner is added by a line here and its include.
constexpr struct {
  const char* name;
  Made (*make)(const ob::SpaceInformationPtr& si);
} kPlanners[] = {
    {kRrtConnect, rrtconnect},        {"rrt", stock<og::RRT>},
    {"rrtstar", stock<og::RRTstar>},  {"informedrrtstar", stock<og::InformedRRTstar>},
    {"bitstar", stock<og::BITstar>},  {"abitstar", stock<og::ABITstar>},
    {"aitstar", stock<og::AITstar>},  {"kpiece", stock<og::KPIECE1>},
    {"bkpiece", stock<og::BKPIECE1>}, {"est", stock<og::EST>},
};

}  // namespace

std::vector<std::string> planner_names() {
  std::vector<std::string> out;
  for (const auto& planner : kPlanners) out.emplace_back(planner.name);
  return out;
}

Status check_planner(const std::string& name) {
  const std::vector<std::string> known = planner_names();
  if (name.empty() || std::find(known.begin(), known.end(), name) != known.end()) return {};
  std::string all;
  for (const std::string& one : known) all += (all.empty() ? "" : ", ") + one;
  return bad_input("there is no planner " + files::shown(name), "--planner", "Choose one of " + all);
}

struct OmplSearch::Impl {
  Random random;
  ob::SpaceInformationPtr si;
  std::shared_ptr<ob::ProblemDefinition> problem;
  Made planner;
  explicit Impl(std::uint64_t seed) : random(seed, "rrt") {}
};

OmplSearch::~OmplSearch() = default;

OmplSearch::OmplSearch(const std::string& name, const StateCheck& check, const Pose& start, const Pose& goal,
                       std::uint64_t seed)
    : impl_(std::make_unique<Impl>(seed)) {
  const auto* kind =
      std::find_if(std::begin(kPlanners), std::end(kPlanners), [&](const auto& k) { return name == k.name; });
  if (kind == std::end(kPlanners)) std::abort();  // a caller without check_planner()
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  auto space = std::make_shared<Space>();
  ob::RealVectorBounds bounds(3);
  for (unsigned k = 0; k < 3; ++k) {
    bounds.setLow(k, box_of(check).first[k]);
    bounds.setHigh(k, box_of(check).second[k]);
  }
  space->setBounds(bounds);
  space->setStateSamplerAllocator([&check, start, goal, random = &impl_->random](const ob::StateSpace* s) {
    return std::make_shared<Sampler>(s, check, start, goal, random);
  });
  impl_->si = std::make_shared<ob::SpaceInformation>(space);
  impl_->si->setStateValidityChecker([&check](const ob::State* s) { return check.valid(read(s)); });
  impl_->si->setMotionValidator(std::make_shared<Validator>(impl_->si, check));
  impl_->si->setup();
  impl_->problem = std::make_shared<ob::ProblemDefinition>(impl_->si);
  ob::ScopedState<Space> from(space), to(space);
  write(start, from.get());
  write(goal, to.get());
  impl_->problem->setStartAndGoalStates(from, to, 1e-9);
  impl_->planner = kind->make(impl_->si);
  impl_->planner->setProblemDefinition(impl_->problem);
  impl_->planner->setup();
}

std::optional<std::vector<Pose>> OmplSearch::solve(const Deadline& end, std::size_t samples) {
  if (end.passed()) return std::nullopt;
  try {
    impl_->planner->solve(ob::PlannerTerminationCondition([&] { return samples-- == 0 || end.passed(); }));
  } catch (const ompl::Exception&) {
    return std::nullopt;
  }
  if (!impl_->problem->hasExactSolution()) return std::nullopt;
  const auto path = impl_->problem->getSolutionPath();
  const auto* geometric = path ? path->as<og::PathGeometric>() : nullptr;
  if (!geometric) return std::nullopt;
  std::vector<Pose> out;
  for (std::size_t i = 0; i < geometric->getStateCount(); ++i) {
    const Pose pose = read(geometric->getState(static_cast<unsigned>(i)));
    if (out.empty() || (pose.p_WB - out.back().p_WB).norm() > 1e-9 ||
        pose.q_WB.angularDistance(out.back().q_WB) > 1e-9)
      out.push_back(pose);
  }
  return out;
}

}  // namespace omniflight::planning
