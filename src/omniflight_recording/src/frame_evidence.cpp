#include "frame_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "omniflight_core/frames.hpp"

namespace omniflight::recording {
namespace {

constexpr double kBlock = 0.1;        // s; noise is averaged over it, motion is not
constexpr int kFewestBlocks = 50;     // for a correlation
constexpr double kMoves = 0.1;        // rad/s or m/s, RMS; less is not judged
constexpr double kFollows = 0.8;      // correlation of two axes that are the same one
constexpr double kContradicts = 0.3;  // and of two that are not
constexpr double kLeastUp = 0.5;      // cosine between the mean specific force and up
constexpr int kFewestForces = 100;

/// Means over blocks of kBlock from t = 0 on; NaN where a block has no sample.
Eigen::MatrixXd block_means(const Signal& s, Eigen::Index blocks) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(blocks, s.width());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(blocks);
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    const double block = s.t_s[static_cast<std::size_t>(i)] / kBlock;
    if (!(block >= 0 && block < static_cast<double>(blocks))) continue;
    const auto k = static_cast<Eigen::Index>(block);
    sum.row(k) += s.values.row(i);
    count(k) += 1;
  }
  for (Eigen::Index k = 0; k < blocks; ++k)
    if (count(k) > 0)
      sum.row(k) /= count(k);
    else
      sum.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
  return sum;
}

Signal derivative(const Signal& s) {
  Signal out = s;
  out.t_s.clear();
  out.values.resize(std::max<Eigen::Index>(0, s.size() - 1), s.width());
  for (Eigen::Index i = 0; i + 1 < s.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double dt = s.t_s[k + 1] - s.t_s[k];
    out.t_s.push_back(s.t_s[k] + 0.5 * dt);
    out.values.row(i) = (s.values.row(i + 1) - s.values.row(i)) / dt;
  }
  return out;
}

/// Correlations of the axes of two signals [3 x 3]; NaN for axes that hardly move.
Eigen::Matrix3d correlations(const Signal& a, const Signal& b, double duration_s) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix3d out = Eigen::Matrix3d::Constant(nan);
  constexpr double kLongest = 1e6;  // blocks
  const auto blocks = static_cast<Eigen::Index>(std::clamp(duration_s / kBlock + 1, 0.0, kLongest));
  const Eigen::MatrixXd x = block_means(a, blocks), y = block_means(b, blocks);
  std::vector<Eigen::Index> both;
  for (Eigen::Index k = 0; k < blocks; ++k)
    if (x.row(k).allFinite() && y.row(k).allFinite()) both.push_back(k);
  if (static_cast<int>(both.size()) < kFewestBlocks) return out;
  const Eigen::MatrixXd u = x(both, Eigen::all), v = y(both, Eigen::all);
  const Eigen::MatrixXd du = u.rowwise() - u.colwise().mean(), dv = v.rowwise() - v.colwise().mean();
  const double n = static_cast<double>(both.size());
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double su = std::sqrt(du.col(i).squaredNorm() / n), sv = std::sqrt(dv.col(j).squaredNorm() / n);
      if (su > kMoves && sv > kMoves) out(i, j) = du.col(i).dot(dv.col(j)) / (n * su * sv);
    }
  return out;
}

/// "x follows y of ..., z follows -z of ...": axes that follow another axis, or their own with the other
/// sign.
std::string contradictions(const Eigen::Matrix3d& c, const std::string& of) {
  static constexpr char kAxis[] = "xyz";
  std::string out;
  for (int i = 0; i < 3; ++i) {
    if (!(c(i, i) < kContradicts)) continue;
    int best = -1;
    for (int j = 0; j < 3; ++j)
      if (std::abs(c(i, j)) > kFollows && (best < 0 || std::abs(c(i, j)) > std::abs(c(i, best)))) best = j;
    if (best >= 0)
      out += std::string(out.empty() ? "" : ", ") + kAxis[i] + " follows " + (c(i, best) < 0 ? "-" : "") +
             kAxis[best];
  }
  return out.empty() ? out : out + " of " + of;
}

const Signal* three(const Recording& r, const char* name) {
  const Signal* s = r.find(name);
  return s != nullptr && s->width() == 3 ? s : nullptr;
}

void judge_gravity(const Signal& acc, const Signal& attitude, Recording& r) {
  constexpr double kGap = 0.2;  // s
  const Eigen::MatrixXd q = resample(attitude, acc.t_s, kGap);
  Vec3 mean = Vec3::Zero();
  int n = 0;
  for (Eigen::Index i = 0; i < acc.size(); ++i) {
    if (!q.row(i).allFinite()) continue;
    mean += Quat(q(i, 0), q(i, 1), q(i, 2), q(i, 3)) * Vec3(acc.values.row(i));
    ++n;
  }
  if (n < kFewestForces) return;
  mean /= n;
  if (mean.norm() < 0.5 * kGravity || mean.z() > kLeastUp * mean.norm()) return;
  char text[80];
  std::snprintf(text, sizeof text, "(%.1f, %.1f, %.1f) m/s2", mean.x(), mean.y(), mean.z());
  r.note(Note::Kind::information, std::string("acc and ") + attitude.name +
                                      " are not in the same axes: turned into the "
                                      "world the mean specific force is " +
                                      text +
                                      ", and not up; a map can say what is "
                                      "right (frame: frd, frame: ned_frd, quaternion: xyzw)");
}

}  // namespace

void note_frame_evidence(Recording& r) {
  const Signal* attitude = r.find("attitude") ? r.find("attitude") : r.find("est_attitude");
  if (attitude && attitude->width() != 4) attitude = nullptr;
  if (const Signal* acc = three(r, "acc"); acc && attitude) judge_gravity(*acc, *attitude, r);
  const double duration_s = r.duration_s;
  if (const Signal* gyro = three(r, "gyro"); gyro && attitude)
    if (const auto what = contradictions(correlations(*gyro, rate_of_attitude(*attitude), duration_s),
                                         "the rate of " + attitude->name);
        !what.empty())
      r.note(
          Note::Kind::information,
          "gyro: " + what +
              "; a map can say what is right (frame: frd; of the attitude frame: ned_frd, quaternion: xyzw)");
  for (const char* prefix : {"", "est_"}) {
    const Signal *p = three(r, (std::string(prefix) + "position").c_str()),
                 *v = three(r, (std::string(prefix) + "velocity").c_str());
    if (!p || !v) continue;
    const auto what =
        contradictions(correlations(*v, derivative(*p), duration_s), "the derivative of " + p->name);
    if (!what.empty())
      r.note(
          Note::Kind::information,
          v->name + ": " + what + "; a map can say what is right (frame: ned, or turned_by for body axes)");
  }
}

}  // namespace omniflight::recording
