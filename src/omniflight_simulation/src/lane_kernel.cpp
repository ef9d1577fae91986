// RK4 of eight vehicles at a time, compiled once for every instruction set and chosen at run time. No fused
// multiply-add and no contraction: every processor gives the same bits.
#include <algorithm>
#include <cmath>

#include "lanes.hpp"

// processors without SSE4 take the plain path: every target costs seconds of compilation
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lane_kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace omniflight::simulation::lanes {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
struct Kernel {
  using V = hn::Vec<D>;
  static constexpr D d{};

  struct V3 {
    V x, y, z;
  };
  struct State {
    V3 p, v, w;
    V qx, qy, qz, qw;
  };
  struct Rate {
    V3 a, dw;           // world, body
    V qx, qy, qz, qw;   // of the quaternion
    V3 specific_force;  // only when asked for
  };

  static HWY_INLINE V load(const Lane& lane, int at) { return hn::LoadU(d, lane + at); }
  static HWY_INLINE void store(V v, Lane& lane, int at) { hn::StoreU(v, d, lane + at); }
  static HWY_INLINE V3 load3(const Lane* lane, int at) {
    return {load(lane[0], at), load(lane[1], at), load(lane[2], at)};
  }
  static HWY_INLINE void store3(const V3& v, Lane* lane, int at) {
    store(v.x, lane[0], at), store(v.y, lane[1], at), store(v.z, lane[2], at);
  }
  static HWY_INLINE V all(double x) { return hn::Set(d, x); }
#ifdef OMNIFLIGHT_LANES_FMA
  static HWY_INLINE V muladd(V a, V b, V c) { return hn::MulAdd(a, b, c); }
  static HWY_INLINE V nmuladd(V a, V b, V c) { return hn::NegMulAdd(a, b, c); }
#else
  static HWY_INLINE V muladd(V a, V b, V c) { return hn::Add(hn::Mul(a, b), c); }
  static HWY_INLINE V nmuladd(V a, V b, V c) { return hn::Sub(c, hn::Mul(a, b)); }
#endif
  static HWY_INLINE V3 cross(const V3& a, const V3& b) {
    return {nmuladd(a.z, b.y, hn::Mul(a.y, b.z)), nmuladd(a.x, b.z, hn::Mul(a.z, b.x)),
            nmuladd(a.y, b.x, hn::Mul(a.x, b.y))};
  }
  static HWY_INLINE V dot(const V3& a, const V3& b) {
    return muladd(a.z, b.z, muladd(a.y, b.y, hn::Mul(a.x, b.x)));
  }
  static HWY_INLINE V3 add(const V3& a, const V3& b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
  }
  static HWY_INLINE V3 sub(const V3& a, const V3& b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
  }
  /// a * s + c
  static HWY_INLINE V3 muladd3(const V3& a, V s, const V3& c) {
    return {muladd(a.x, s, c.x), muladd(a.y, s, c.y), muladd(a.z, s, c.z)};
  }
  static HWY_INLINE V3 scale(const V3& a, V s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
  static HWY_INLINE V3 symmetric_times(const Lane* m, int at, const V3& x, bool products) {
    V3 out{hn::Mul(load(m[0], at), x.x), hn::Mul(load(m[1], at), x.y), hn::Mul(load(m[2], at), x.z)};
    if (products) {
      const V xy = load(m[3], at), xz = load(m[4], at), yz = load(m[5], at);
      out.x = muladd(xz, x.z, muladd(xy, x.y, out.x));
      out.y = muladd(yz, x.z, muladd(xy, x.x, out.y));
      out.z = muladd(yz, x.y, muladd(xz, x.x, out.z));
    }
    return out;
  }

  /// Rotation matrix of a quaternion that need not have unit length, times its squared length: the division
  /// runs beside the products and is applied to their result.
  struct Rotation {
    V3 row[3];
    V inverse;  ///< one over the squared length
    HWY_INLINE V3 world_unscaled(const V3& b) const {
      return {dot(row[0], b), dot(row[1], b), dot(row[2], b)};
    }
    HWY_INLINE V3 world(const V3& b) const { return scale(world_unscaled(b), inverse); }
    HWY_INLINE V3 body(const V3& w) const {
      return scale(muladd3(row[2], w.z, muladd3(row[1], w.y, scale(row[0], w.x))), inverse);
    }
    HWY_INLINE V3 up() const { return scale(row[2], inverse); }  ///< the world's vertical in body axes
  };
  static HWY_INLINE Rotation rotation(const State& s) {
    const V xx = hn::Mul(s.qx, s.qx), yy = hn::Mul(s.qy, s.qy), zz = hn::Mul(s.qz, s.qz),
            ww = hn::Mul(s.qw, s.qw);
    const V x2 = hn::Add(s.qx, s.qx), y2 = hn::Add(s.qy, s.qy), z2 = hn::Add(s.qz, s.qz);
    const V xy = hn::Mul(x2, s.qy), xz = hn::Mul(x2, s.qz), yz = hn::Mul(y2, s.qz);
    const V wx = hn::Mul(x2, s.qw), wy = hn::Mul(y2, s.qw), wz = hn::Mul(z2, s.qw);
    const V wpx = hn::Add(ww, xx), ypz = hn::Add(yy, zz), wmx = hn::Sub(ww, xx), ymz = hn::Sub(yy, zz);
    return {{{hn::Sub(wpx, ypz), hn::Sub(xy, wz), hn::Add(xz, wy)},
             {hn::Add(xy, wz), hn::Add(wmx, ymz), hn::Sub(yz, wx)},
             {hn::Sub(xz, wy), hn::Add(yz, wx), hn::Sub(wmx, ymz)}},
            hn::Div(all(1.0), hn::Add(wpx, ypz))};
  }

  /// Forces of the air on the body, world axes.
  static HWY_INLINE void air(const Common& c, const Block& b, int at, const State& s, V3& f_W) {
    const V half = all(0.5 * c.air_density), tiny = all(1e-12);
    const V vv = dot(s.v, s.v);
    f_W = muladd3(s.v, hn::Neg(hn::Mul(hn::Mul(half, load(b.area, at)), hn::Sqrt(vv))), f_W);
    const V3 wind{hn::Sub(load(b.wind[0], at), s.v.x), hn::Sub(load(b.wind[1], at), s.v.y), hn::Neg(s.v.z)};
    const V k = hn::Mul(half, load(b.wind_area, at));
    f_W = muladd3(wind, hn::Mul(k, hn::Sqrt(hn::Add(dot(wind, wind), tiny))), f_W);
    f_W = muladd3(s.v, hn::Mul(k, hn::Sqrt(hn::Add(vv, tiny))), f_W);
  }

  /// Rotor drag and axial inflow, body axes: f_i = -|Omega_i| (kd v_i + (kz - kd) (n_i . v_i) n_i) at hub p_i
  /// with v_i = v + w x p_i. The sums over the rotors do not need v and w, so that these come in once.
  static HWY_INLINE void blades(const Common& c, const Block& b, int at, const State& s, const Rotation& R,
                                const V* speed, V3& force, V3& torque) {
    const V zero = hn::Zero(d);
    const V3 v = R.body(s.v);
    V sum = zero, square[6] = {zero, zero, zero, zero, zero, zero};
    V3 lever{zero, zero, zero}, axial_f = lever, axial_t = lever;
    for (int i = 0; i < c.rotors; ++i) {
      const Common::Rotor& r = c.rotor[i];
      const V fast = hn::Abs(speed[i]);
      const V3 n = load3(b.axis[i], at), m = load3(b.moment[i], at);
      sum = hn::Add(sum, fast);
      lever = muladd3({all(r.p.x()), all(r.p.y()), all(r.p.z())}, fast, lever);
      for (int k = 0; k < 6; ++k) square[k] = muladd(all(r.square[k]), fast, square[k]);
      const V along = hn::Mul(fast, hn::Add(dot(n, v), dot(m, s.w)));
      axial_f = muladd3(n, along, axial_f);
      axial_t = muladd3(m, along, axial_t);
    }
    const V kd = load(b.drag_in_plane, at), kn = hn::Sub(kd, load(b.drag_axial, at)), minus = hn::Neg(kd);
    force = muladd3(muladd3(v, sum, cross(s.w, lever)), minus, muladd3(axial_f, kn, force));
    const V3 turning{muladd(square[4], s.w.z, muladd(square[3], s.w.y, hn::Mul(square[0], s.w.x))),
                     muladd(square[5], s.w.z, muladd(square[3], s.w.x, hn::Mul(square[1], s.w.y))),
                     muladd(square[5], s.w.y, muladd(square[4], s.w.x, hn::Mul(square[2], s.w.z)))};
    torque = muladd3(add(cross(lever, v), turning), minus, muladd3(axial_t, kn, torque));
  }

  static HWY_INLINE void flapping(const Common& c, const Block& b, int at, const State& s, const Rotation& R,
                                  const V* speed, V3& torque) {
    const V3 v = R.body(s.v);
    for (int i = 0; i < c.rotors; ++i) {
      const Common::Rotor& r = c.rotor[i];
      const V3 hub = add(v, cross(s.w, {all(r.p.x()), all(r.p.y()), all(r.p.z())}));
      const V k = hn::Neg(hn::Mul(hn::Abs(speed[i]), load(b.flapping, at)));
      torque = muladd3(cross(hub, load3(b.axis[i], at)), k, torque);
    }
  }

  static HWY_INLINE void ground(const Common& c, const Block& b, int at, const State& s, const Rotation& R,
                                const V* square, V3& force, V3& torque) {
    const V3 up = R.up();
    for (int i = 0; i < c.rotors; ++i) {
      const Common::Rotor& r = c.rotor[i];
      const V3 n = load3(b.axis[i], at);
      const V3 p{all(r.p.x()), all(r.p.y()), all(r.p.z())};
      const V height = hn::Sub(hn::Add(s.p.z, dot(up, p)), all(c.floor_z));
      const V ratio = hn::Div(all(r.radius), hn::Mul(all(4.0), hn::Max(height, all(0.05 * r.radius))));
      const V x = hn::Min(hn::Mul(load(b.ground_strength, at), hn::Mul(ratio, ratio)), all(0.75));
      const V gain = hn::Div(x, hn::Sub(all(1.0), x));
      const V thrust = hn::Mul(all(r.thrust_coefficient), square[i]), upward = dot(up, n);
      // wash that goes down only; thrust times the cosine of the wash is |thrust| times that of the axis
      const V size = hn::IfThenElseZero(hn::Gt(hn::Mul(thrust, upward), hn::Zero(d)),
                                        hn::Mul(gain, hn::Mul(hn::Abs(thrust), upward)));
      force = muladd3(n, size, force);
      torque = muladd3(load3(b.moment[i], at), size, torque);
    }
  }

  static HWY_INLINE void rotor_momentum(const Common& c, const Block& b, int at, const State& s,
                                        const V* speed, V3& torque) {
    V3 momentum{hn::Zero(d), hn::Zero(d), hn::Zero(d)}, spin_up = momentum;
    for (int i = 0; i < c.rotors; ++i) {
      const V3 n = load3(b.axis[i], at);
      const V spin = all(c.rotor[i].spin);
      const V acceleration = hn::Mul(hn::Sub(load(b.command[i], at), speed[i]), load(b.inverse_tau[i], at));
      momentum = muladd3(n, hn::Mul(spin, speed[i]), momentum);
      spin_up = muladd3(n, hn::Mul(spin, acceleration), spin_up);
    }
    torque = muladd3(add(spin_up, cross(s.w, momentum)), load(b.rotor_inertia, at), torque);
  }

  static HWY_INLINE V carried(const Block& b, int at, const State& s) {
    const V height = hn::Sub(s.p.z, load(b.cable_start, at));
    return hn::Mul(load(b.cable_density, at),
                   hn::Min(hn::Max(height, hn::Zero(d)), load(b.cable_length, at)));
  }

  /// Rotors at one stage. The wrench follows from the speeds alone, and they from time alone.
  struct Rotors {
    V3 force, torque;
    V speed[kRotors], square[kRotors];  ///< only where an effect asks for them
  };
  /// The rotors at `stages` stages. share: how far the motors have come towards their command at each.
  template <int kStages, bool kSpeeds>
  static HWY_INLINE void spin(const Common& c, const Block& b, int at, Rotors (&out)[kStages]) {
    V share[kStages];
    for (int k = 0; k < kStages; ++k) {
      out[k].force = out[k].torque = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
      share[k] = load(b.share[k][0], at);
    }
    for (int i = 0; i < c.rotors; ++i) {
      const V start = load(b.speed[i], at), change = hn::Sub(load(b.command[i], at), start);
      const V3 f = load3(b.map[i], at), t = load3(b.map[i] + 3, at);
      for (int k = 0; k < kStages; ++k) {
        const V speed = muladd(b.one_lag ? share[k] : load(b.share[k][i], at), change, start);
        const V square = hn::Mul(speed, c.rotor[i].bidirectional ? hn::Abs(speed) : speed);
        out[k].force = muladd3(f, square, out[k].force);
        out[k].torque = muladd3(t, square, out[k].torque);
        if constexpr (kSpeeds) out[k].speed[i] = speed, out[k].square[i] = square;
      }
    }
  }

  /// The equations of motion at one stage.
  template <bool kAnswers, bool kSpeeds>
  static HWY_INLINE Rate evaluate(const Common& c, const Block& b, int at, const State& s,
                                  const Rotors& rotors) {
    const Rotation R = rotation(s);
    V3 force = rotors.force, torque = rotors.torque;
    if constexpr (kSpeeds) {
      const V *const speed = rotors.speed, *const square = rotors.square;
      if (c.blades) blades(c, b, at, s, R, speed, force, torque);
      if (c.flapping) flapping(c, b, at, s, R, speed, torque);
      if (c.ground) ground(c, b, at, s, R, square, force, torque);
      if (c.rotor_momentum) rotor_momentum(c, b, at, s, speed, torque);
    }

    V3 f_W{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    if (c.world_force) {
      const V k = load(b.stiffness, at);
      f_W = load3(b.pull, at);
      f_W.x = nmuladd(k, hn::Sub(s.p.x, load(b.anchor[0], at)), f_W.x);
      f_W.y = nmuladd(k, hn::Sub(s.p.y, load(b.anchor[1], at)), f_W.y);
    }
    if (c.air) air(c, b, at, s, f_W);

    Rate out;
    const V g = all(c.gravity), weight_mass = load(b.weight_mass, at);
    const V3 Jw = symmetric_times(b.inertia, at, s.w, c.products);
    torque = sub(torque, cross(s.w, Jw));
    if (!b.coupled) {
      // the mass is the same in all directions; a cable's is lifted along the world's vertical only
      const V inverse_mass = load(b.inverse_mass, at);
      out.a = muladd3(R.world_unscaled(force), hn::Mul(R.inverse, inverse_mass), scale(f_W, inverse_mass));
      if (c.cable) out.a.z = hn::Mul(out.a.z, hn::Div(weight_mass, hn::Add(weight_mass, carried(b, at, s))));
      out.a.z = hn::Sub(out.a.z, g);
      out.dw = symmetric_times(b.inverse_inertia, at, torque, c.products);
      if (kAnswers) out.specific_force = R.body({out.a.x, out.a.y, hn::Add(out.a.z, g)});
    } else {
      const V3 com = load3(b.com, at), up = R.up(), g_B = scale(up, hn::Neg(g));
      const V mass = load(b.mass, at);
      V3 rhs = add(force, R.body(f_W));
      V cable = hn::Zero(d);
      if (c.cable) cable = carried(b, at, s);
      rhs = muladd3(g_B, hn::Add(weight_mass, cable), rhs);
      rhs = muladd3(cross(s.w, cross(s.w, com)), hn::Neg(mass), rhs);
      torque = muladd3(cross(com, g_B), mass, torque);
      const V r[6] = {rhs.x, rhs.y, rhs.z, torque.x, torque.y, torque.z};
      V nu[6];
      for (int row = 0; row < 6; ++row) {
        nu[row] = hn::Mul(load(b.inverse_generalised[6 * row], at), r[0]);
        for (int k = 1; k < 6; ++k)
          nu[row] = muladd(load(b.inverse_generalised[6 * row + k], at), r[k], nu[row]);
      }
      if (c.cable) {  // Sherman and Morrison: the cable's mass acts along the vertical only
        V y[6];
        for (int row = 0; row < 6; ++row)
          y[row] = muladd(load(b.inverse_generalised[6 * row + 2], at), up.z,
                          muladd(load(b.inverse_generalised[6 * row + 1], at), up.y,
                                 hn::Mul(load(b.inverse_generalised[6 * row], at), up.x)));
        const V share_of = hn::Div(hn::Mul(cable, dot(up, {nu[0], nu[1], nu[2]})),
                                   muladd(cable, dot(up, {y[0], y[1], y[2]}), all(1.0)));
        for (int row = 0; row < 6; ++row) nu[row] = nmuladd(y[row], share_of, nu[row]);
      }
      const V3 a_B{nu[0], nu[1], nu[2]};
      out.a = R.world(a_B);
      out.dw = {nu[3], nu[4], nu[5]};
      if (kAnswers) out.specific_force = sub(a_B, g_B);
    }
    // dq = q (0, w) / 2
    const V half = all(0.5);
    const V hx = hn::Mul(half, s.w.x), hy = hn::Mul(half, s.w.y), hz = hn::Mul(half, s.w.z);
    out.qx = nmuladd(s.qz, hy, muladd(s.qy, hz, hn::Mul(s.qw, hx)));
    out.qy = nmuladd(s.qx, hz, muladd(s.qz, hx, hn::Mul(s.qw, hy)));
    out.qz = nmuladd(s.qy, hx, muladd(s.qx, hy, hn::Mul(s.qw, hz)));
    out.qw = nmuladd(s.qz, hz, nmuladd(s.qy, hy, hn::Neg(hn::Mul(s.qx, hx))));
    return out;
  }

  static HWY_INLINE State read(const Block& b, int at) {
    return {load3(b.p, at),   load3(b.v, at),   load3(b.w, at),  load(b.q[0], at),
            load(b.q[1], at), load(b.q[2], at), load(b.q[3], at)};
  }
  static HWY_INLINE State moved(const State& s, const V3& v, const Rate& k, V h) {
    return {muladd3(v, h, s.p),    muladd3(k.a, h, s.v),  muladd3(k.dw, h, s.w), muladd(k.qx, h, s.qx),
            muladd(k.qy, h, s.qy), muladd(k.qz, h, s.qz), muladd(k.qw, h, s.qw)};
  }
  /// sum += weight * k; the sum has the shape of a state
  static HWY_INLINE void gather(State& sum, const V3& v, const Rate& k, V weight) {
    sum = moved(sum, v, k, weight);
  }

  static HWY_INLINE void advance_motors(const Common& c, Block& b, int at) {
    for (int i = 0; i < c.rotors; ++i) {
      const V s = load(b.speed[i], at);
      store(muladd(load(b.share_end[i], at), hn::Sub(load(b.command[i], at), s), s), b.speed[i], at);
    }
  }

  template <bool kSpeeds>
  static HWY_INLINE void step(const Common& c, Block& b, int at) {
    const V h = all(c.step), half = all(0.5 * c.step), sixth = all(c.step / 6), third = all(c.step / 3);
    Rotors rotors[4];
    spin<4, kSpeeds>(c, b, at, rotors);
    const State s = read(b, at);
    const Rate k1 = evaluate<false, kSpeeds>(c, b, at, s, rotors[0]);
    State sum = moved(s, s.v, k1, sixth);
    const State s2 = moved(s, s.v, k1, half);
    const Rate k2 = evaluate<false, kSpeeds>(c, b, at, s2, rotors[1]);
    gather(sum, s2.v, k2, third);
    const State s3 = moved(s, s2.v, k2, half);
    const Rate k3 = evaluate<false, kSpeeds>(c, b, at, s3, rotors[2]);
    gather(sum, s3.v, k3, third);
    const State s4 = moved(s, s3.v, k3, h);
    const Rate k4 = evaluate<false, kSpeeds>(c, b, at, s4, rotors[3]);
    gather(sum, s4.v, k4, sixth);
    advance_motors(c, b, at);

    const V n =
        muladd(sum.qw, sum.qw, muladd(sum.qz, sum.qz, muladd(sum.qy, sum.qy, hn::Mul(sum.qx, sum.qx))));
    const V unit = hn::Div(all(1.0), hn::Sqrt(n));
    // a vehicle that is out of range stays where it was (a comparison with what is no number is false)
    const auto most = [](const V3& v) { return hn::Max(hn::Max(hn::Abs(v.x), hn::Abs(v.y)), hn::Abs(v.z)); };
    const V far = all(1e3);
    const auto within = hn::And(hn::And(hn::Le(most(sum.p), far), hn::Eq(n, n)),
                                hn::And(hn::Le(most(sum.v), far), hn::Le(most(sum.w), far)));
    const auto fine = hn::And(within, hn::Eq(load(b.lost, at), hn::Zero(d)));
    store(hn::IfThenElse(fine, hn::Zero(d), all(1.0)), b.lost, at);
    const auto keep = [&](V now, V before, Lane& lane) {
      store(hn::IfThenElse(fine, now, before), lane, at);
    };
    keep(sum.p.x, s.p.x, b.p[0]), keep(sum.p.y, s.p.y, b.p[1]), keep(sum.p.z, s.p.z, b.p[2]);
    keep(sum.v.x, s.v.x, b.v[0]), keep(sum.v.y, s.v.y, b.v[1]), keep(sum.v.z, s.v.z, b.v[2]);
    keep(sum.w.x, s.w.x, b.w[0]), keep(sum.w.y, s.w.y, b.w[1]), keep(sum.w.z, s.w.z, b.w[2]);
    keep(hn::Mul(sum.qx, unit), s.qx, b.q[0]), keep(hn::Mul(sum.qy, unit), s.qy, b.q[1]);
    keep(hn::Mul(sum.qz, unit), s.qz, b.q[2]), keep(hn::Mul(sum.qw, unit), s.qw, b.q[3]);
  }

  static void answers(const Common& c, Block& b, int at) {
    Rotors rotors[1];
    spin<1, true>(c, b, at, rotors);
    const Rate k = evaluate<true, true>(c, b, at, read(b, at), rotors[0]);
    store3(k.specific_force, b.specific_force, at);
    store3(k.dw, b.angular_acceleration, at);
  }

  static void remap(const Common& c, Block& b) {
    const int n = static_cast<int>(hn::Lanes(d));
    Lane cosine, sine;
    for (int k = 0; k < kLanes; ++k) cosine[k] = std::cos(b.alpha[k]), sine[k] = std::sin(b.alpha[k]);
    for (int at = 0; at < b.used; at += n) {
      const V ca = load(cosine, at), sa = load(sine, at);
      const V gain = muladd(load(b.thrust_gain_per_alpha, at), load(b.alpha, at), load(b.thrust_gain, at));
      for (int i = 0; i < c.rotors; ++i) {
        const Common::Rotor& r = c.rotor[i];
        const V3 axis{muladd(all(r.sine.x()), sa, muladd(all(r.cosine.x()), ca, all(r.constant.x()))),
                      muladd(all(r.sine.y()), sa, muladd(all(r.cosine.y()), ca, all(r.constant.y()))),
                      muladd(all(r.sine.z()), sa, muladd(all(r.cosine.z()), ca, all(r.constant.z())))};
        V map[6];
        for (int row = 0; row < 6; ++row)
          map[row] =
              muladd(load(b.map_by_tilt[2][i][row], at), sa,
                     muladd(load(b.map_by_tilt[1][i][row], at), ca, load(b.map_by_tilt[0][i][row], at)));
        // the efficiency scales the whole nominal wrench of the rotor
        const V3 p{all(r.p.x()), all(r.p.y()), all(r.p.z())};
        store3(axis, b.axis[i], at);
        store3(cross(p, axis), b.moment[i], at);
        const V3 force = scale(axis, hn::Mul(all(r.thrust_coefficient), gain));
        const V3 torque = muladd3(force, all(r.spin * r.drag_ratio), cross(p, force));
        store3(add({map[0], map[1], map[2]}, force), b.map[i], at);
        store3(add({map[3], map[4], map[5]}, torque), b.map[i] + 3, at);
      }
    }
    for (int k = 0; k < kLanes; ++k) b.mapped_alpha[k] = b.alpha[k];
  }

  /// Tilt and commands at the start of a step.
  static HWY_INLINE void begin_step(const Common& c, Block& b, const Trains& trains) {
    const int n = static_cast<int>(hn::Lanes(d));
    const double most = c.tilt_rate * c.step;
    bool moved_tilt = false;
    for (int at = 0; at < b.used; at += n) {
      for (int i = 0; i < c.rotors; ++i) store(load(b.target[i], at), b.command[i], at);
      const V command = load(b.alpha_command, at), alpha = load(b.alpha, at);
      const V error = hn::Sub(command, alpha);
      const V next = most > 0 ? hn::Add(alpha, hn::Min(hn::Max(error, all(-most)), all(most))) : command;
      store(next, b.alpha, at);
      moved_tilt = moved_tilt || !hn::AllTrue(d, hn::Eq(next, load(b.mapped_alpha, at)));
    }
    if (trains.any) moved_tilt = begin_with_trains(c, b, trains) || moved_tilt;
    if (moved_tilt) remap(c, b);
    if (c.ideal_motors)
      for (int i = 0; i < c.rotors; ++i)
        for (int k = 0; k < kLanes; ++k)
          if (b.ideal[i][k]) b.speed[i][k] = b.command[i][k];
  }

  /// The same for vehicles whose commands pass through more than a lag.
  static bool begin_with_trains(const Common& c, Block& b, const Trains& trains) {
    bool moved_tilt = false;
    for (int k = 0; k < b.used; ++k) {
      physics::Actuators* const train = trains.of[k].get();
      if (!train) continue;
      double command[kRotors];
      for (int i = 0; i < c.rotors; ++i) command[i] = b.target[i][k];
      train->begin_step({command, static_cast<std::size_t>(c.rotors)}, b.alpha_command[k], 0.0);
      for (int i = 0; i < c.rotors; ++i) b.command[i][k] = train->target(static_cast<std::size_t>(i));
      b.alpha[k] = train->alpha();
      moved_tilt = moved_tilt || b.alpha[k] != b.mapped_alpha[k];
    }
    return moved_tilt;
  }

  static void run(const Common& c, Block& b, const Trains& trains, int steps, bool held) {
    const int n = static_cast<int>(hn::Lanes(d));
    const bool speeds = c.blades || c.flapping || c.ground || c.rotor_momentum;
    b.answered = steps == 0;
    for (int k = 0; k < steps; ++k) {
      begin_step(c, b, trains);
      for (int at = 0; at < b.used; at += n) {
        if (held)
          advance_motors(c, b, at);
        else if (speeds)
          step<true>(c, b, at);
        else
          step<false>(c, b, at);
      }
    }
    if (steps == 0) {
      bool stale = false;
      for (int k = 0; k < b.used; ++k) stale = stale || b.alpha[k] != b.mapped_alpha[k];
      if (stale) remap(c, b);
      for (int at = 0; at < b.used; at += n) answers(c, b, at);
    }
  }
};

void Run(const Common& c, Block& b, const Trains& trains, int steps, bool held) {
  if (b.used == 1)
    Kernel<hn::CappedTag<double, 1>>::run(c, b, trains, steps, held);
  else
    Kernel<hn::CappedTag<double, kLanes>>::run(c, b, trains, steps, held);
}

std::string Name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::simulation::lanes
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace omniflight::simulation::lanes {

HWY_EXPORT(Run);
HWY_EXPORT(Name);

void run(const Common& common, Block& block, const Trains& trains, int steps, bool held) {
  HWY_DYNAMIC_DISPATCH(Run)(common, block, trains, steps, held);
}

std::string instruction_set() { return HWY_DYNAMIC_DISPATCH(Name)(); }

}  // namespace omniflight::simulation::lanes
#endif
