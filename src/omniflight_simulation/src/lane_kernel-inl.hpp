// RK4 of eight vehicles at a time. No fused multiply-add and no contraction: every processor gives the same
// bits. Each source that includes this compiles it for those instruction sets of OMNIFLIGHT_LANE_TARGETS;
// that there are two lets two processors compile. No include guard: foreach_target.h includes it once for
// every instruction set.
#include <algorithm>
#include <cmath>

#include "lanes.hpp"

// processors without SSE4 take the plain path: every target costs seconds of compilation
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lane_kernel-inl.hpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"

#if HWY_TARGET & (OMNIFLIGHT_LANE_TARGETS)
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
    V qx, qy, qz, qw;   // twice that of the quaternion
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
  /// kUnit: it has unit length, as at the beginning of a step.
  template <bool kUnit = false>
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
            kUnit ? all(1.0) : hn::Div(all(1.0), hn::Add(wpx, ypz))};
  }

  /// Drag of the body, world axes.
  static HWY_INLINE void drag(const Common& c, const Block& b, int at, const State& s, V3& f_W) {
    const V k = hn::Mul(all(-0.5 * c.air_density), load(b.area, at));
    f_W = muladd3(s.v, hn::Mul(k, hn::Sqrt(dot(s.v, s.v))), f_W);
  }

  /// What wind changes in it, world axes.
  static HWY_INLINE void wind(const Common& c, const Block& b, int at, const State& s, V3& f_W) {
    const V half = all(0.5 * c.air_density), tiny = all(1e-12);
    const V vv = dot(s.v, s.v);
    const V3 wind{hn::Sub(load(b.wind[0], at), s.v.x), hn::Sub(load(b.wind[1], at), s.v.y), hn::Neg(s.v.z)};
    const V k = hn::Mul(half, load(b.wind_area, at));
    f_W = muladd3(wind, hn::Mul(k, hn::Sqrt(hn::Add(dot(wind, wind), tiny))), f_W);
    f_W = muladd3(s.v, hn::Mul(k, hn::Sqrt(hn::Add(vv, tiny))), f_W);
  }

  struct Symmetric {
    V xx, yy, zz, xy, xz, yz;
  };
  static HWY_INLINE V3 times(const Symmetric& m, const V3& x) {
    return {muladd(m.xz, x.z, muladd(m.xy, x.y, hn::Mul(m.xx, x.x))),
            muladd(m.yz, x.z, muladd(m.yy, x.y, hn::Mul(m.xy, x.x))),
            muladd(m.zz, x.z, muladd(m.yz, x.y, hn::Mul(m.xz, x.x)))};
  }
  /// a * s + c
  static HWY_INLINE Symmetric muladd6(const Symmetric& a, V s, const Symmetric& c) {
    return {muladd(a.xx, s, c.xx), muladd(a.yy, s, c.yy), muladd(a.zz, s, c.zz),
            muladd(a.xy, s, c.xy), muladd(a.xz, s, c.xz), muladd(a.yz, s, c.yz)};
  }
  /// a s^T + c of vectors whose product is symmetric
  static HWY_INLINE Symmetric outer(const V3& a, const V3& s, const Symmetric& c) {
    return {muladd(a.x, s.x, c.xx), muladd(a.y, s.y, c.yy), muladd(a.z, s.z, c.zz),
            muladd(a.x, s.y, c.xy), muladd(a.x, s.z, c.xz), muladd(a.y, s.z, c.yz)};
  }

  static HWY_INLINE Symmetric load6(const Lane* lane, int at) {
    return {load(lane[0], at), load(lane[1], at), load(lane[2], at),
            load(lane[3], at), load(lane[4], at), load(lane[5], at)};
  }
  static HWY_INLINE void store6(const Symmetric& m, Lane* lane, int at) {
    store(m.xx, lane[0], at), store(m.yy, lane[1], at), store(m.zz, lane[2], at);
    store(m.xy, lane[3], at), store(m.xz, lane[4], at), store(m.yz, lane[5], at);
  }

  /// Rotor drag and axial inflow, body axes: f_i = -|Omega_i| (kd v_i + (kz - kd) (n_i . v_i) n_i) at hub p_i
  /// with v_i = v + w x p_i. All of them together are minus a symmetric matrix [F, C; C^T, T] times (v, w):
  /// the sum over the rotors of |Omega_i| (kd [I, -[p]; [p], |p|^2 I - p p^T] + (kz - kd) [n; m] [n; m]^T)
  /// with m = p x n. In `out` F, T, and C row by row. (Members and no arrays of vectors: what is indexed by a
  /// variable stays in memory.)
  static HWY_INLINE void damp(const Common& c, const Block& b, int at, const V* fast, Lane* out) {
    const V zero = hn::Zero(d);
    const Symmetric none{zero, zero, zero, zero, zero, zero};
    Symmetric F = none, T = none;
    V3 X{zero, zero, zero}, Y = X, Z = X;
    for (int i = 0; i < c.rotors; ++i) {
      const V3 n = load3(b.axis[i], at), m = load3(b.moment[i], at);
      const V3 force = scale(n, fast[i]);
      F = outer(force, n, F);
      X = muladd3(m, force.x, X), Y = muladd3(m, force.y, Y), Z = muladd3(m, force.z, Z);
      T = outer(scale(m, fast[i]), m, T);
    }
    V speed = zero;
    V3 p{zero, zero, zero};
    Symmetric square = none;
    for (int i = 0; i < c.rotors; ++i) {
      const Common::Rotor& r = c.rotor[i];
      speed = hn::Add(speed, fast[i]);
      p = muladd3({all(r.p.x()), all(r.p.y()), all(r.p.z())}, fast[i], p);
      square = muladd6({all(r.square[0]), all(r.square[1]), all(r.square[2]), all(r.square[3]),
                        all(r.square[4]), all(r.square[5])},
                       fast[i], square);
    }
    const V kd = load(b.drag_in_plane, at), kn = hn::Sub(load(b.drag_axial, at), kd);
    const V straight = hn::Mul(kd, speed);
    p = scale(p, kd);
    store6(muladd6(F, kn, {straight, straight, straight, zero, zero, zero}), out, at);
    store6(muladd6(T, kn, muladd6(square, kd, none)), out + 6, at);
    store3(muladd3(X, kn, {zero, p.z, hn::Neg(p.y)}), out + 12, at);
    store3(muladd3(Y, kn, {hn::Neg(p.z), zero, p.x}), out + 15, at);
    store3(muladd3(Z, kn, {p.y, hn::Neg(p.x), zero}), out + 18, at);
  }
  static HWY_NOINLINE void damp_now(const Common& c, Block& b, int at) {
    V fast[kRotors];
    for (int i = 0; i < c.rotors; ++i) fast[i] = hn::Abs(load(b.speed[i], at));
    damp(c, b, at, fast, b.damping[b.damping_begins]);
  }
  static HWY_INLINE void blades(const Lane* damping, int at, const V3& v, const V3& w, V3& force,
                                V3& torque) {
    const V3 x = load3(damping + 12, at), y = load3(damping + 15, at), z = load3(damping + 18, at);
    force = sub(force, add(times(load6(damping, at), v), {dot(x, w), dot(y, w), dot(z, w)}));
    torque = sub(torque, muladd3(z, v.z, muladd3(y, v.y, muladd3(x, v.x, times(load6(damping + 6, at), w)))));
  }

  static HWY_INLINE void flapping(const Common& c, const Block& b, int at, const State& s, const Rotation& R,
                                  const V* speed, V3& torque) {
    const V3 v = R.body(s.v);
    for (int i = 0; i < c.rotors; ++i) {
      const Common::Rotor& r = c.rotor[i];
      const V3 hub = add(v, cross(s.w, {all(r.p.x()), all(r.p.y()), all(r.p.z())}));
      const V k = hn::Mul(hn::Abs(speed[i]), load(b.flapping, at));
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

  /// Upward momentum a second [N] that what leaves the floor takes.
  static HWY_INLINE V picked_up(const Block& b, int at, const State& s) {
    const V height = hn::Sub(s.p.z, load(b.cable_start, at)), climb = hn::Max(s.v.z, hn::Zero(d));
    const auto lifting = hn::And(hn::Gt(height, hn::Zero(d)), hn::Lt(height, load(b.cable_length, at)));
    return hn::IfThenElseZero(lifting, hn::Mul(load(b.cable_density, at), hn::Mul(climb, climb)));
  }

  /// Rotors at one stage. The wrench follows from the speeds alone, and they from time alone.
  struct Rotors {
    V3 force, torque;
    V speed[kRotors], square[kRotors];  ///< only where an effect asks for them
    const Lane* damping = nullptr;      ///< only where rotors have drag
  };
  template <Reverse kReverse = Reverse::some>
  static HWY_INLINE V signed_square(const Common& c, int i, V speed) {
    const bool reverses = kReverse == Reverse::all || (kReverse == Reverse::some && c.rotor[i].bidirectional);
    return hn::Mul(speed, reverses ? hn::Abs(speed) : speed);
  }
  /// The rotors at the beginning of a step.
  template <bool kSpeeds, bool kBlades>
  static HWY_INLINE void begin(const Common& c, Block& b, int at, Rotors& out) {
    V3 force{hn::Zero(d), hn::Zero(d), hn::Zero(d)}, torque = force;
    if (b.end_known) {
      force = load3(b.end_wrench, at);
      torque = load3(b.end_wrench + 3, at);
    }
    for (int i = 0; (kSpeeds || !b.end_known) && i < c.rotors; ++i) {
      const V speed = load(b.speed[i], at), square = signed_square(c, i, speed);
      if constexpr (kSpeeds) out.speed[i] = speed, out.square[i] = square;
      if (b.end_known) continue;
      force = muladd3(load3(b.map[i], at), square, force);
      torque = muladd3(load3(b.map[i] + 3, at), square, torque);
    }
    out.force = force;
    out.torque = torque;
    if (!kBlades || !c.blades) return;
    if (!b.end_known) damp_now(c, b, at);
    out.damping = b.damping[b.damping_begins];
  }
  /// What rotor drag needs of the speeds of a step.
  struct Fast {
    V begin[kRotors];  ///< speed
    V end[kRotors];    ///< |speed|
    V crossed;         ///< negative when a speed changed its sign
  };
  /// |speed| in the middle beyond what it would be on the line between beginning and end, at the share of the
  /// first rotor: speeds that change their sign, and lags that differ.
  static HWY_NOINLINE void bend(const Common& c, Block& b, int at, const Fast& fast) {
    V bent[kRotors];
    Lane rest[21];
    const Lane* const command = b.relays ? b.command : b.target;
    for (int i = 0; i < c.rotors; ++i) {
      const V begun = fast.begin[i], arrived = load(b.speed[i], at), from = hn::Abs(begun);
      const V half_way = muladd(load(b.share_middle[i], at), hn::Sub(load(command[i], at), begun), begun);
      const V rise = hn::Sub(fast.end[i], from), on_line = muladd(rise, load(b.share_of_way, at), from);
      bent[i] = hn::IfThenElse(hn::Lt(hn::Mul(begun, arrived), hn::Zero(d)),
                               hn::Sub(hn::Abs(half_way), on_line), hn::Mul(rise, load(b.bend[i], at)));
    }
    damp(c, b, at, bent, rest);
    for (int k = 0; k < 21; ++k)
      store(hn::Add(load(b.damping[1][k], at), load(rest[k], at)), b.damping[1][k], at);
  }
  /// The speeds in the middle and at the end of a step, and the wrench of N rotors (0: of all).
  template <bool kSpeeds, bool kBlades, Reverse kReverse, int N>
  static HWY_INLINE void spin_rotors(const Common& c, Block& b, int at, Rotors& middle, Rotors& end,
                                     Fast& fast) {
    const Lane* const command = b.relays ? b.command : b.target;
    const int count = N > 0 ? N : c.rotors, lag = b.lags_differ ? 1 : 0;
    V3 middle_f{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    V3 middle_t = middle_f, end_f = middle_f, end_t = middle_f;
    V crossed = hn::Zero(d);
#pragma GCC unroll 8
    for (int i = 0; i < count; ++i) {
      const V begun = load(b.speed[i], at), change = hn::Sub(load(command[i], at), begun);
      const V3 f = load3(b.map[i], at), t = load3(b.map[i] + 3, at);
      const V half_way = muladd(load(b.share_middle[lag * i], at), change, begun);
      const V arrived = muladd(load(b.share_end[lag * i], at), change, begun);
      const V half_square = signed_square<kReverse>(c, i, half_way),
              end_square = signed_square<kReverse>(c, i, arrived);
      middle_f = muladd3(f, half_square, middle_f);
      middle_t = muladd3(t, half_square, middle_t);
      end_f = muladd3(f, end_square, end_f);
      end_t = muladd3(t, end_square, end_t);
      store(arrived, b.speed[i], at);
      if constexpr (kSpeeds) {
        middle.speed[i] = half_way, middle.square[i] = half_square;
        end.speed[i] = arrived, end.square[i] = end_square;
      }
      if constexpr (kBlades) {
        fast.begin[i] = begun, fast.end[i] = hn::Abs(arrived);
        crossed = hn::Min(crossed, hn::Mul(begun, arrived));
      }
    }
    if constexpr (kBlades) fast.crossed = crossed;
    middle.force = middle_f, middle.torque = middle_t;
    end.force = end_f, end.torque = end_t;
    store3(end_f, b.end_wrench, at);
    store3(end_t, b.end_wrench + 3, at);
  }
  /// The rotors in the middle and at the end of a step, at which they arrive.
  template <bool kSpeeds, bool kBlades>
  static HWY_INLINE void spin(const Common& c, Block& b, int at, Rotors& middle, Rotors& end) {
    Fast fast;
    if (c.reverse == Reverse::none && c.rotors == 8)
      spin_rotors<kSpeeds, kBlades, Reverse::none, 8>(c, b, at, middle, end, fast);
    else if (c.reverse == Reverse::all && c.rotors == 8)
      spin_rotors<kSpeeds, kBlades, Reverse::all, 8>(c, b, at, middle, end, fast);
    else
      spin_rotors<kSpeeds, kBlades, Reverse::some, 0>(c, b, at, middle, end, fast);
    if (!kBlades || !c.blades) return;
    const Lane* const begins = b.damping[b.damping_begins];
    Lane *const in_middle = b.damping[1], *const ends = b.damping[2 - b.damping_begins];
    damp(c, b, at, fast.end, ends);
    middle.damping = in_middle, end.damping = ends;
    const V share = load(b.share_of_way, at);
    for (int k = 0; k < 21; ++k) {
      const V from = load(begins[k], at);
      store(muladd(hn::Sub(load(ends[k], at), from), share, from), in_middle[k], at);
    }
    if (HWY_UNLIKELY(b.lags_differ || !hn::AllTrue(d, hn::Eq(fast.crossed, hn::Zero(d)))))
      bend(c, b, at, fast);
  }

  /// Rates of turning under a torque beside the gyroscopic one.
  static HWY_INLINE void turn(const Block& b, int at, const State& s, const V3& torque, Rate& out) {
    const V3& w = s.w;
    // 2 dq = q (0, w)
    out.qx = nmuladd(s.qz, w.y, muladd(s.qy, w.z, hn::Mul(s.qw, w.x)));
    out.qy = nmuladd(s.qx, w.z, muladd(s.qz, w.x, hn::Mul(s.qw, w.y)));
    out.qz = nmuladd(s.qy, w.x, muladd(s.qx, w.y, hn::Mul(s.qw, w.z)));
    out.qw = nmuladd(s.qz, w.z, nmuladd(s.qy, w.y, hn::Neg(hn::Mul(s.qx, w.x))));
    // J^-1 (torque - w x J w); of the diagonal of J only the differences matter
    const V3 inverse = load3(b.inverse_inertia, at), gap = load3(b.inertia_gap, at);
    out.dw = {nmuladd(hn::Mul(inverse.x, gap.x), hn::Mul(w.y, w.z), hn::Mul(inverse.x, torque.x)),
              nmuladd(hn::Mul(inverse.y, gap.y), hn::Mul(w.z, w.x), hn::Mul(inverse.y, torque.y)),
              nmuladd(hn::Mul(inverse.z, gap.z), hn::Mul(w.x, w.y), hn::Mul(inverse.z, torque.z))};
  }
  /// Acceleration [world] by a force [body], without gravity, where the mass is the same in all directions.
  static HWY_INLINE V3 accelerate(const Rotation& R, const V3& force, V inverse_mass) {
    return scale(R.world_unscaled(force), hn::Mul(R.inverse, inverse_mass));
  }

  /// The equations of motion at one stage. kGeneral: the centre of mass may be off the origin and the inertia
  /// may have products. kBegins: at the beginning of a step.
  template <bool kAnswers, bool kBegins, bool kGeneral, bool kSpeeds, bool kBlades, bool kPlace>
  static HWY_INLINE Rate evaluate(const Common& c, const Block& b, int at, const State& s,
                                  const Rotors& rotors) {
    Rate out;
    V3 force = rotors.force, torque = rotors.torque;
    const Rotation R = rotation<kBegins>(s);
    if (kBlades && c.blades) blades(rotors.damping, at, R.body(s.v), s.w, force, torque);
    if constexpr (kSpeeds) {
      const V *const speed = rotors.speed, *const square = rotors.square;
      if (c.flapping) flapping(c, b, at, s, R, speed, torque);
      if (c.ground) ground(c, b, at, s, R, square, force, torque);
      if (c.rotor_momentum) rotor_momentum(c, b, at, s, speed, torque);
    }
    turn(b, at, s, torque, out);

    V3 f_W{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    const bool cabled = kPlace && c.cable, pushed = kPlace && (c.world_force || c.drag || c.wind || cabled);
    if (kPlace && c.world_force) {
      const V k = load(b.stiffness, at);
      f_W = load3(b.pull, at);
      f_W.x = nmuladd(k, hn::Sub(s.p.x, load(b.anchor[0], at)), f_W.x);
      f_W.y = nmuladd(k, hn::Sub(s.p.y, load(b.anchor[1], at)), f_W.y);
    }
    if (kPlace && c.drag) drag(c, b, at, s, f_W);
    if (kPlace && c.wind) wind(c, b, at, s, f_W);
    if (cabled) f_W.z = hn::Sub(f_W.z, picked_up(b, at, s));

    const V g = all(c.gravity), weight_mass = load(b.weight_mass, at);
    if (kGeneral) {
      const V3 gap = load3(b.inertia_gap, at), w = s.w;
      torque = {nmuladd(gap.x, hn::Mul(w.y, w.z), torque.x), nmuladd(gap.y, hn::Mul(w.z, w.x), torque.y),
                nmuladd(gap.z, hn::Mul(w.x, w.y), torque.z)};
    }
    if (kGeneral && c.products) {
      const V xy = load(b.inertia[3], at), xz = load(b.inertia[4], at), yz = load(b.inertia[5], at);
      torque = sub(torque,
                   cross(s.w, {muladd(xz, s.w.z, hn::Mul(xy, s.w.y)), muladd(yz, s.w.z, hn::Mul(xy, s.w.x)),
                               muladd(yz, s.w.y, hn::Mul(xz, s.w.x))}));
    }
    if (!kGeneral || !b.coupled) {
      // the mass is the same in all directions; a cable's is lifted along the world's vertical only
      const V inverse_mass = load(b.inverse_mass, at);
      out.a = accelerate(R, force, inverse_mass);
      if (pushed) out.a = muladd3(f_W, inverse_mass, out.a);
      if (cabled) out.a.z = hn::Mul(out.a.z, hn::Div(weight_mass, hn::Add(weight_mass, carried(b, at, s))));
      out.a.z = hn::Sub(out.a.z, g);
      if constexpr (kGeneral) out.dw = symmetric_times(b.inverse_inertia, at, torque, c.products);
      if (kAnswers) out.specific_force = R.body({out.a.x, out.a.y, hn::Add(out.a.z, g)});
    } else {
      const V3 com = load3(b.com, at), up = R.up(), g_B = scale(up, hn::Neg(g));
      const V mass = load(b.mass, at);
      V3 rhs = force;
      if (pushed) rhs = add(rhs, R.body(f_W));
      V cable = hn::Zero(d);
      if (cabled) cable = carried(b, at, s);
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
      if (cabled) {  // Sherman and Morrison: the cable's mass acts along the vertical only
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
    return out;
  }

  static HWY_INLINE State read(const Block& b, int at) {
    return {load3(b.p, at),   load3(b.v, at),   load3(b.w, at),  load(b.q[0], at),
            load(b.q[1], at), load(b.q[2], at), load(b.q[3], at)};
  }
  /// The state at a stage: from s with velocity v and rate k for a time h. Position and velocity only where
  /// something depends on them.
  template <bool kPlace>
  static HWY_INLINE State moved(const State& s, const V3& v, const Rate& k, V h, V half_h) {
    State out;
    if constexpr (kPlace) {
      out.p = muladd3(v, h, s.p);
      out.v = muladd3(k.a, h, s.v);
    } else {
      out.p = s.p, out.v = s.v;
    }
    out.w = muladd3(k.dw, h, s.w);
    out.qx = muladd(k.qx, half_h, s.qx), out.qy = muladd(k.qy, half_h, s.qy);
    out.qz = muladd(k.qz, half_h, s.qz), out.qw = muladd(k.qw, half_h, s.qw);
    return out;
  }
  /// k1 + 2 (k2 + k3) + k4, the inner sum given
  static HWY_INLINE V weighted(V k1, V inner, V k4) {
    return hn::Add(hn::Add(inner, inner), hn::Add(k1, k4));
  }
  static HWY_INLINE V3 weighted3(const V3& k1, const V3& inner, const V3& k4) {
    return {weighted(k1.x, inner.x, k4.x), weighted(k1.y, inner.y, k4.y), weighted(k1.z, inner.z, k4.z)};
  }

  static HWY_INLINE void advance_motors(const Common& c, Block& b, int at) {
    const Lane* const command = b.relays ? b.command : b.target;
    for (int i = 0; i < c.rotors; ++i) {
      const V s = load(b.speed[i], at);
      store(muladd(load(b.share_end[b.lags_differ ? i : 0], at), hn::Sub(load(command[i], at), s), s),
            b.speed[i], at);
    }
  }

  template <bool kGeneral, bool kSpeeds, bool kBlades, bool kPlace>
  static HWY_INLINE void step(const Common& c, Block& b, int at) {
    const double step = c.step;
    const V h = all(step), half = all(0.5 * step), quarter = all(0.25 * step), sixth = all(step / 6);
    const V twelfth = all(step / 12), square = all(step * step / 6);
    Rotors start, middle, end;
    begin<kSpeeds, kBlades>(c, b, at, start);
    spin<kSpeeds, kBlades>(c, b, at, middle, end);
    const State s = read(b, at);
    Rate k1, k2, k3, k4;
    if constexpr (kGeneral || kSpeeds || kBlades || kPlace) {
      k1 = evaluate<false, true, kGeneral, kSpeeds, kBlades, kPlace>(c, b, at, s, start);
      const State s2 = moved<kPlace>(s, s.v, k1, half, quarter);
      k2 = evaluate<false, false, kGeneral, kSpeeds, kBlades, kPlace>(c, b, at, s2, middle);
      const State s3 = moved<kPlace>(s, s2.v, k2, half, quarter);
      k3 = evaluate<false, false, kGeneral, kSpeeds, kBlades, kPlace>(c, b, at, s3, middle);
      const State s4 = moved<kPlace>(s, s3.v, k3, h, half);
      k4 = evaluate<false, false, kGeneral, kSpeeds, kBlades, kPlace>(c, b, at, s4, end);
    } else {  // it turns wherever it goes, and goes where it has turned
      turn(b, at, s, start.torque, k1);
      const State s2 = moved<false>(s, s.v, k1, half, quarter);
      turn(b, at, s2, middle.torque, k2);
      const State s3 = moved<false>(s, s.v, k2, half, quarter);
      turn(b, at, s3, middle.torque, k3);
      const State s4 = moved<false>(s, s.v, k3, h, half);
      turn(b, at, s4, end.torque, k4);
      const V inverse_mass = load(b.inverse_mass, at), g = all(c.gravity);
      k1.a = accelerate(rotation<true>(s), start.force, inverse_mass), k1.a.z = hn::Sub(k1.a.z, g);
      k2.a = accelerate(rotation(s2), middle.force, inverse_mass), k2.a.z = hn::Sub(k2.a.z, g);
      k3.a = accelerate(rotation(s3), middle.force, inverse_mass), k3.a.z = hn::Sub(k3.a.z, g);
      k4.a = accelerate(rotation(s4), end.force, inverse_mass), k4.a.z = hn::Sub(k4.a.z, g);
    }
    const V3 a23 = add(k2.a, k3.a), dw23 = add(k2.dw, k3.dw);
    const V qx23 = hn::Add(k2.qx, k3.qx), qy23 = hn::Add(k2.qy, k3.qy), qz23 = hn::Add(k2.qz, k3.qz),
            qw23 = hn::Add(k2.qw, k3.qw);
    State sum;
    sum.p = muladd3(add(k1.a, a23), square, muladd3(s.v, h, s.p));
    sum.v = muladd3(weighted3(k1.a, a23, k4.a), sixth, s.v);
    sum.w = muladd3(weighted3(k1.dw, dw23, k4.dw), sixth, s.w);
    sum.qx = muladd(weighted(k1.qx, qx23, k4.qx), twelfth, s.qx);
    sum.qy = muladd(weighted(k1.qy, qy23, k4.qy), twelfth, s.qy);
    sum.qz = muladd(weighted(k1.qz, qz23, k4.qz), twelfth, s.qz);
    sum.qw = muladd(weighted(k1.qw, qw23, k4.qw), twelfth, s.qw);

    const V n = hn::Add(muladd(sum.qx, sum.qx, hn::Mul(sum.qy, sum.qy)),
                        muladd(sum.qz, sum.qz, hn::Mul(sum.qw, sum.qw)));
    // one over the root of n, which RK4 leaves close to one: by its series, else exactly. A comparison with
    // what is no number is false.
    V unit = nmuladd(all(0.5), n, all(1.5));
    const auto near = hn::Lt(hn::Abs(hn::Sub(n, all(1.0))), all(1e-8));
    const auto most = [](const V3& v) { return hn::Add(hn::Add(hn::Abs(v.x), hn::Abs(v.y)), hn::Abs(v.z)); };
    const V size = hn::Add(hn::Add(most(sum.p), most(sum.v)), most(sum.w));
    const V far = all(1e3);
    if (HWY_LIKELY(hn::AllTrue(d, hn::And(near, hn::Lt(size, far))) && !b.any_lost)) {
      put(sum, unit, b, at);
      return;
    }
    unit = hn::IfThenElse(near, unit, hn::Div(all(1.0), hn::Sqrt(n)));
    put_within(s, sum, unit, n, b, at);
  }

  static HWY_INLINE void put(const State& s, V unit, Block& b, int at) {
    store3(s.p, b.p, at), store3(s.v, b.v, at), store3(s.w, b.w, at);
    store(hn::Mul(s.qx, unit), b.q[0], at), store(hn::Mul(s.qy, unit), b.q[1], at);
    store(hn::Mul(s.qz, unit), b.q[2], at), store(hn::Mul(s.qw, unit), b.q[3], at);
  }
  /// The same, but a vehicle that is out of range stays where it was.
  static HWY_NOINLINE void put_within(const State& before, const State& sum, const V& unit, const V& n,
                                      Block& b, int at) {
    const V far = all(1e3);
    const auto inside = [&](const V3& v) {
      return hn::And(hn::And(hn::Le(hn::Abs(v.x), far), hn::Le(hn::Abs(v.y), far)),
                     hn::Le(hn::Abs(v.z), far));
    };
    const auto within = hn::And(hn::And(inside(sum.p), hn::Eq(n, n)), hn::And(inside(sum.v), inside(sum.w)));
    const auto fine = hn::And(within, hn::Eq(load(b.lost, at), hn::Zero(d)));
    store(hn::IfThenElse(fine, hn::Zero(d), all(1.0)), b.lost, at);
    b.any_lost = b.any_lost || !hn::AllTrue(d, fine);
    const auto keep = [&](V now, V then) { return hn::IfThenElse(fine, now, then); };
    const auto keep3 = [&](const V3& now, const V3& then) {
      return V3{keep(now.x, then.x), keep(now.y, then.y), keep(now.z, then.z)};
    };
    const State kept{keep3(sum.p, before.p),
                     keep3(sum.v, before.v),
                     keep3(sum.w, before.w),
                     keep(hn::Mul(sum.qx, unit), before.qx),
                     keep(hn::Mul(sum.qy, unit), before.qy),
                     keep(hn::Mul(sum.qz, unit), before.qz),
                     keep(hn::Mul(sum.qw, unit), before.qw)};
    put(kept, all(1.0), b, at);
  }

  static void answers(const Common& c, Block& b, int at) {
    Rotors rotors;
    begin<true, true>(c, b, at, rotors);
    const Rate k = evaluate<true, true, true, true, true, true>(c, b, at, read(b, at), rotors);
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
    b.end_known = false;
    for (int k = 0; k < kLanes; ++k) b.mapped_alpha[k] = b.alpha[k];
  }

  /// Tilt and commands at the start of a step.
  static HWY_INLINE void begin_step(const Common& c, Block& b, const Trains& trains) {
    const int n = static_cast<int>(hn::Lanes(d));
    const double most = c.tilt_rate * c.step;
    bool moved_tilt = false;
    b.relays = trains.any || c.rotor_momentum || c.ideal_motors;
    for (int at = 0; at < b.used; at += n) {
      for (int i = 0; b.relays && i < c.rotors; ++i) store(load(b.target[i], at), b.command[i], at);
      const V command = load(b.alpha_command, at), alpha = load(b.alpha, at);
      const V error = hn::Sub(command, alpha);
      const V next = most > 0 ? hn::Add(alpha, hn::Min(hn::Max(error, all(-most)), all(most))) : command;
      store(next, b.alpha, at);
      moved_tilt = moved_tilt || !hn::AllTrue(d, hn::Eq(next, load(b.mapped_alpha, at)));
    }
    if (trains.any) moved_tilt = begin_with_trains(c, b, trains) || moved_tilt;
    if (moved_tilt) remap(c, b);
    if (c.ideal_motors) b.end_known = false;
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
    const bool speeds = c.flapping || c.ground || c.rotor_momentum;
    const bool place = c.world_force || c.drag || c.wind || c.cable;
    b.answered = steps == 0;
    for (int k = 0; k < steps; ++k) {
      begin_step(c, b, trains);
      for (int at = 0; at < b.used; at += n) {
        if (held)
          advance_motors(c, b, at);
        else if (b.coupled || c.products)
          step<true, true, true, true>(c, b, at);
        else if (speeds && c.blades)
          step<false, true, true, true>(c, b, at);
        else if (speeds)
          step<false, true, false, true>(c, b, at);
        else if (c.blades)
          step<false, false, true, true>(c, b, at);
        else if (place)
          step<false, false, false, true>(c, b, at);
        else
          step<false, false, false, false>(c, b, at);
      }
      b.end_known = !held;
      b.damping_begins = 2 - b.damping_begins;
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
  if (b.used == 1)  // in two lanes: what lies beside a single number is nothing to count with
    Kernel<hn::CappedTag<double, 2>>::run(c, b, trains, steps, held);
  else
    Kernel<hn::CappedTag<double, kLanes>>::run(c, b, trains, steps, held);
}

std::string Name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace omniflight::simulation::lanes
HWY_AFTER_NAMESPACE();
#endif
