// The quadratic programs of a flight with kicks, and a stop watch that tells median and tail over them.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "../test/omnimorph.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::allocation {

inline constexpr int kRotors = 8, kPasses = 9;

/// Each wish differs a little from the last.
inline std::vector<AllocationInput> flight() {
  Random rng(1);
  std::vector<AllocationInput> inputs(1000);
  Vec6 wish = Vec6::Zero();
  Quat q = Quat::Identity();
  for (AllocationInput& in : inputs) {
    for (int i = 0; i < 6; ++i) wish[i] = 0.97 * wish[i] + (i < 3 ? 1.0 : 6.0) * rng.normal();
    q = (q * exp_rotation(0.02 * Vec3(rng.normal(), rng.normal(), rng.normal()))).normalized();
    in.qdd_ref = wish;
    in.q_WB = q;
  }
  return inputs;
}

struct Qp {
  QpMatrix H;
  QpVector g, lower, upper;
  ActiveSet before{};  ///< active set of the program before
  QpVector exact;      ///< N, its minimum
};

/// Program of one period at tilt alpha [rad] with weights on squared speeds: there general solvers still
/// converge. u_before [N].
inline Qp program(const vehicle::Vehicle& v, const AllocatorConfig& config, const AllocationInput& in,
                  double alpha, const QpVector& u_before) {
  Vec6 per_wrench, weight;
  per_wrench << Vec3::Constant(1 / v.mass), v.inertia.diagonal().cwiseInverse();
  weight << Vec3::Constant(config.w_linear), Vec3::Constant(config.w_angular);
  const double per_newton = std::pow(v.rotors[0].thrust_coefficient * 4 * kPi * kPi, -2);
  const vehicle::AllocationMatrix A = per_wrench.asDiagonal() * v.allocation_matrix(alpha);
  Vec6 target = in.qdd_ref;
  target.head<3>() = in.q_WB.conjugate() * Vec3(target.head<3>() + kGravity * Vec3::UnitZ());
  Qp qp{A.transpose() * weight.asDiagonal() * A,
        -A.transpose() * weight.cwiseProduct(target) - config.w_rate * per_newton * u_before,
        v.lower_thrusts(),
        v.upper_thrusts(),
        {},
        {}};
  qp.H.diagonal().array() += (config.w_input + config.w_rate) * per_newton;
  return qp;
}

/// The flight with the weights of cases A and B, at 35 deg: 2000 programs.
inline const std::vector<Qp>& programs() {
  static const std::vector<Qp> all = [] {
    const vehicle::Vehicle v = omnimorph();
    std::vector<Qp> out;
    for (const AllocatorConfig& config : {AllocatorConfig::case_a(), AllocatorConfig::case_b()}) {
      QpVector u = QpVector::Zero(kRotors);
      ActiveSet active{};
      for (const AllocationInput& in : flight()) {
        Qp qp = program(v, config, in, to_radians(35), u);
        qp.before = active;
        const BoxQpSolution s = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
        qp.exact = u = s.u;
        active = s.active_set;
        out.push_back(std::move(qp));
      }
    }
    return out;
  }();
  return all;
}

/// Flies through solve(0), solve(1), ... 9 times and keeps the best time of each; reports median, 99th
/// percentile and mean over them [ns]. solve(0) starts anew, so that each pass does the same work. The
/// clock's own 20 to 30 ns are included for everybody.
template <class Solve>
void time_each(benchmark::State& state, std::size_t count, Solve solve) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> ns(count, HUGE_VAL);
  for (auto _ : state) {
    for (int pass = 0; pass < kPasses; ++pass) {
      for (std::size_t i = 0; i < count; ++i) {
        const auto begin = Clock::now();
        solve(i);
        const double took = std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
        ns[i] = std::min(ns[i], took);
      }
    }
    std::sort(ns.begin(), ns.end());
    double sum = 0;
    for (const double x : ns) sum += x;
    state.counters["median_ns"] = ns[count / 2];
    state.counters["p99_ns"] = ns[count * 99 / 100];
    state.counters["mean_ns"] = sum / static_cast<double>(count);
  }
}

}  // namespace omniflight::allocation
