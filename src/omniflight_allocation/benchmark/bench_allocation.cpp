// Time of the allocator on the quadratic programs of a closed loop, beside the peers that Debian packages:
// quadprog (Goldfarb and Idnani's dual active-set method, r-cran-quadprog), dlib's box-constrained solver and
// NLopt's SLSQP. Peers that are not installed are left out. Quote ratios from one run only.
#include <Eigen/Cholesky>

#include "flight_programs.hpp"
#include "omniflight_allocation/feasible_set.hpp"
#include "peers.hpp"

namespace omniflight::allocation {
namespace {

void ours(benchmark::State& state, bool warm) {
  const auto& qps = programs();
  double kkt = 0, saturated = 0;
  time_each(state, qps.size(), [&](std::size_t i) {
    const Qp& qp = qps[i];
    const BoxQpSolution s = solve_box_qp(qp.H, qp.g, qp.lower, qp.upper, warm ? qp.before : ActiveSet{});
    kkt = std::max(kkt, s.kkt_residual);
    saturated += s.active_bounds > 0;
    benchmark::DoNotOptimize(s.u.data());
  });
  state.counters["kkt"] = kkt;
  state.counters["saturated"] = saturated / (kPasses * static_cast<double>(qps.size()));
}
BENCHMARK_CAPTURE(ours, warm, true)->Iterations(1);
BENCHMARK_CAPTURE(ours, cold, false)->Iterations(1);

// With the matrix of the program before, as at a tilt that stays: the programs of each case have one matrix.
void ours_kept_matrix(benchmark::State& state) {
  const auto& qps = programs();
  BoxQpSolver solver;
  double kkt = 0;
  time_each(state, qps.size(), [&](std::size_t i) {
    const Qp& qp = qps[i];
    if (i % (qps.size() / 2) == 0) solver.set_matrix(qp.H);
    const BoxQpSolution s = solver.solve(qp.g, qp.lower, qp.upper, qp.before);
    kkt = std::max(kkt, s.kkt_residual);
    benchmark::DoNotOptimize(s.u.data());
  });
  state.counters["kkt"] = kkt;
}
BENCHMARK(ours_kept_matrix)->Iterations(1);

// The same with the gap of 0.15 N about zero kept exactly.
void ours_with_gap(benchmark::State& state) {
  const auto& qps = programs();
  const QpVector gap = QpVector::Constant(kRotors, 0.15);
  double nodes = 0, most = 0;
  time_each(state, qps.size(), [&](std::size_t i) {
    const Qp& qp = qps[i];
    const GapQpSolution s = solve_gap_qp(qp.H, qp.g, qp.lower, qp.upper, gap, qp.before);
    nodes += s.nodes;
    most = std::max<double>(most, s.nodes);
    benchmark::DoNotOptimize(s.best.u.data());
  });
  state.counters["programs_mean"] = nodes / (kPasses * static_cast<double>(qps.size()));
  state.counters["programs_most"] = most;
}
BENCHMARK(ours_with_gap)->Iterations(1);

template <class Peer>
void peer(benchmark::State& state) {
  const auto& qps = programs();
  Peer solver;
  double error = 0;
  time_each(state, qps.size(), [&](std::size_t i) {
    solver.solve(qps[i]);
    error = std::max(error, (qps[i].exact - solver.u()).cwiseAbs().maxCoeff());
  });
  state.counters["worst_error_N"] = error;
}
#ifdef OMNIFLIGHT_HAVE_QUADPROG
BENCHMARK(peer<QuadprogPeer>)->Iterations(1);
#endif
#ifdef OMNIFLIGHT_HAVE_DLIB
BENCHMARK(peer<DlibPeer>)->Iterations(1);
#endif
#ifdef OMNIFLIGHT_HAVE_NLOPT
BENCHMARK(peer<NloptPeer>)->Iterations(1);
#endif

// The floor of any method with a new matrix: one factorisation and solution, bounds ignored.
void floor_eigen_llt(benchmark::State& state) {
  const auto& qps = programs();
  time_each(state, qps.size(), [&](std::size_t i) {
    const Eigen::Matrix<double, kRotors, kRotors> H = qps[i].H;
    const Eigen::Matrix<double, kRotors, 1> u = H.llt().solve(-qps[i].g.head<kRotors>());
    benchmark::DoNotOptimize(u.data());
  });
}
BENCHMARK(floor_eigen_llt)->Iterations(1);

// A whole period: assembly, one or three tilts, choice, accelerations and the wrench that is missing.
void period(benchmark::State& state, TiltMode mode, bool keep_min_thrust, int tilts) {
  AllocatorConfig config = AllocatorConfig::case_b();
  config.input_unit = InputUnit::hz2;
  config.tilt_mode = mode;
  config.keep_min_thrust = keep_min_thrust;
  config.tilt_candidates = tilts;
  auto allocator = Allocator::create(omnimorph(), config).value();
  const auto inputs = flight();
  time_each(state, inputs.size(), [&](std::size_t i) {
    if (i == 0) allocator.reset(config.initial_tilt);
    const auto out = allocator.allocate(inputs[i]);
    benchmark::DoNotOptimize(out->u.data());
  });
}
BENCHMARK_CAPTURE(period, fixed_tilt, TiltMode::fixed, false, 1)->Iterations(1);
BENCHMARK_CAPTURE(period, search_of_three_tilts, TiltMode::search, false, 3)->Iterations(1);
BENCHMARK_CAPTURE(period, search_of_eight_tilts, TiltMode::search, false, 8)->Iterations(1);
BENCHMARK_CAPTURE(period, search_with_gap, TiltMode::search, true, 3)->Iterations(1);

// The sets of `omniflight design`: 2^8 vertices, every degree of the tilt, the omnidirectional angle.
void design_of_61_tilts(benchmark::State& state) {
  const vehicle::Vehicle v = omnimorph();
  std::vector<double> alphas;
  for (int degree = 0; degree <= 60; ++degree) alphas.push_back(to_radians(degree));
  for (auto _ : state) benchmark::DoNotOptimize(design(v, alphas)->points.data());
}
BENCHMARK(design_of_61_tilts)->Unit(benchmark::kMillisecond);

#ifdef OMNIFLIGHT_HAVE_QUADPROG
// The same search as somebody writes it around a general solver: three programs assembled and solved.
void peer_period_search_of_three_tilts(benchmark::State& state) {
  const vehicle::Vehicle v = omnimorph();
  const AllocatorConfig config = AllocatorConfig::case_b();
  const auto inputs = flight();
  QuadprogPeer solver;
  QpVector u = QpVector::Zero(kRotors);
  double alpha = config.initial_tilt;
  time_each(state, inputs.size(), [&](std::size_t i) {
    if (i == 0) alpha = config.initial_tilt, u.setZero();
    double lowest = HUGE_VAL;
    const QpVector before = u;
    const double centre = alpha;
    for (const double step : {0.0, -config.tilt_step, config.tilt_step}) {
      const double trial = std::clamp(centre + step, 0.0, v.tilt.max);
      const Qp qp = program(v, config, inputs[i], trial, before);
      solver.solve(qp);
      const double cost = 0.5 * solver.u().dot(qp.H * solver.u()) + qp.g.dot(solver.u());
      if (cost < lowest) lowest = cost, alpha = trial, u = solver.u();
    }
  });
}
BENCHMARK(peer_period_search_of_three_tilts)->Iterations(1);
#endif

}  // namespace
}  // namespace omniflight::allocation

BENCHMARK_MAIN();
