// Time of the allocator on the quadratic programs of a closed loop, beside NLopt's SLSQP and Eigen's
// factorisation. Quote ratios from one run only.
#include <benchmark/benchmark.h>
#include <nlopt.h>

#include <Eigen/Cholesky>

#include "../test/omnimorph.hpp"
#include "omniflight_allocation/allocator.hpp"
#include "omniflight_core/random.hpp"

namespace omniflight::allocation {
namespace {

constexpr int kRotors = 8;

// A flight with kicks: each wish differs a little from the last.
std::vector<AllocationInput> flight() {
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
};

// The same flight as quadratic programs, weights of case B on squared speeds: there general solvers still
// converge.
std::vector<Qp> problems() {
  const vehicle::Vehicle v = omnimorph();
  const AllocatorConfig config = AllocatorConfig::case_b();
  Vec6 per_wrench, weight;
  per_wrench << Vec3::Constant(1 / v.mass), v.inertia.diagonal().cwiseInverse();
  weight << Vec3::Constant(config.w_linear), Vec3::Constant(config.w_angular);
  std::vector<Qp> out;
  const double per_newton = std::pow(v.rotors[0].thrust_coefficient * 4 * kPi * kPi, -2);
  const double w_rate = config.w_rate * per_newton, w_input = config.w_input * per_newton;
  QpVector u = QpVector::Zero(kRotors);
  for (const AllocationInput& in : flight()) {
    const vehicle::AllocationMatrix A = per_wrench.asDiagonal() * v.allocation_matrix(to_radians(35));
    Vec6 target = in.qdd_ref;
    target.head<3>() = in.q_WB.conjugate() * Vec3(target.head<3>() + kGravity * Vec3::UnitZ());
    Qp qp{A.transpose() * weight.asDiagonal() * A, -A.transpose() * weight.cwiseProduct(target) - w_rate * u,
          v.lower_thrusts(), v.upper_thrusts()};
    qp.H.diagonal().array() += w_input + w_rate;
    u = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper).u;
    out.push_back(qp);
  }
  return out;
}

void single_qp(benchmark::State& state, bool warm) {
  const auto qps = problems();
  ActiveSet active{};
  std::size_t i = 0, saturated = 0;
  double worst = 0;
  for (auto _ : state) {
    const Qp& qp = qps[i++ % qps.size()];
    const BoxQpSolution s = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper, warm ? active : ActiveSet{});
    active = s.active_set;
    saturated += s.active_bounds > 0;
    worst = std::max(worst, s.kkt_residual);
    benchmark::DoNotOptimize(s.u.data());
  }
  state.counters["saturated"] = static_cast<double>(saturated) / static_cast<double>(state.iterations());
  state.counters["kkt"] = worst;
}
BENCHMARK_CAPTURE(single_qp, warm, true);
BENCHMARK_CAPTURE(single_qp, cold, false);

double slsqp_cost(unsigned n, const double* x, double* gradient, void* data) {
  const Qp& qp = *static_cast<const Qp*>(data);
  const Eigen::Map<const Eigen::VectorXd> u(x, n);
  const Eigen::Matrix<double, kRotors, 1> Hu = qp.H * u;
  if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, n) = Hu + qp.g;
  return 0.5 * u.dot(Hu) + qp.g.dot(u);
}

// The peer Debian packages: cost scaled like ours, started at the previous answer.
void peer_nlopt_slsqp(benchmark::State& state) {
  auto qps = problems();
  nlopt_opt opt = nlopt_create(NLOPT_LD_SLSQP, kRotors);
  nlopt_set_ftol_rel(opt, 1e-12);
  nlopt_set_maxeval(opt, 200);
  for (Qp& qp : qps) {
    const double scale = qp.H.diagonal().maxCoeff();
    qp.H /= scale;
    qp.g /= scale;
  }
  nlopt_set_lower_bounds(opt, qps[0].lower.data());
  nlopt_set_upper_bounds(opt, qps[0].upper.data());
  std::array<double, kRotors> u{};
  std::size_t i = 0;
  double worst = 0;
  for (auto _ : state) {
    Qp& qp = qps[i++ % qps.size()];
    nlopt_set_min_objective(opt, slsqp_cost, &qp);
    double cost = 0;
    benchmark::DoNotOptimize(nlopt_optimize(opt, u.data(), &cost));
    state.PauseTiming();
    const Eigen::Map<const Eigen::VectorXd> found(u.data(), kRotors);
    const BoxQpSolution exact = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper);
    worst = std::max(worst, (exact.u - found).cwiseAbs().maxCoeff());
    state.ResumeTiming();
  }
  state.counters["worst_error_N"] = worst;
  nlopt_destroy(opt);
}
BENCHMARK(peer_nlopt_slsqp);

// The floor of any method with a new matrix: one factorisation and solution, bounds ignored.
void floor_eigen_llt(benchmark::State& state) {
  const auto qps = problems();
  std::size_t i = 0;
  for (auto _ : state) {
    const Qp& qp = qps[i++ % qps.size()];
    const Eigen::Matrix<double, kRotors, kRotors> H = qp.H;
    const Eigen::Matrix<double, kRotors, 1> u = H.llt().solve(-qp.g.head<kRotors>());
    benchmark::DoNotOptimize(u.data());
  }
}
BENCHMARK(floor_eigen_llt);

void period(benchmark::State& state, TiltMode mode) {
  AllocatorConfig config = AllocatorConfig::case_b();
  config.tilt_mode = mode;
  auto allocator = Allocator::create(omnimorph(), config).value();
  const auto inputs = flight();
  std::size_t i = 0;
  for (auto _ : state) {
    const auto out = allocator.allocate(inputs[i++ % inputs.size()]);
    benchmark::DoNotOptimize(out->u.data());
  }
}
BENCHMARK_CAPTURE(period, fixed_tilt, TiltMode::fixed);
BENCHMARK_CAPTURE(period, search_of_three_tilts, TiltMode::search);

}  // namespace
}  // namespace omniflight::allocation

BENCHMARK_MAIN();
