/* SPDX-License-Identifier: GPL-2.0-or-later
   The continuous law of Baxter, Tuzun, Burnell, Heyes, PRE 55, 3546 (1997) ("B97"), sec. II, for pairs of discs.

   Signs as in pair_loop.h; sigma_ij = R_i + R_j is `radsum`, d of B97 is xi_t.  Words and symbols: docs/glossary.md. */

#ifndef DISC_KERNELS_CONTINUOUS_H
#define DISC_KERNELS_CONTINUOUS_H

#include "pair_loop.h"

#include <algorithm>
#include <cmath>

namespace disc
{

struct ContinuousLaw {
  double force = 1.0;               // elastic force at r = sigma_ij: the weight m g of the largest grain, > 0
  double index = 36.0;              // n of F = force (sigma_ij/r)^(n+1), > 0
  double cutoff = 1.2;              // r0/sigma_ij, >= 1: the force is cut there, not shifted
  double hooke = 0.0;               // k > 0: F = k (sigma_ij - r) for r < sigma_ij instead [force/length]
  double mu = 0.0;                  // friction coefficient, >= 0
  double alpha = 1.214;             // dmax = alpha mu (r0 - r), > 0 with friction
  double damping = 0.5;             // fraction of critical damping, of normal and tangential motion alike, >= 0
  double printed_rotation = 0.0;    // 1: lever arms as printed in eqs. 6 and 13, r_ij instead of r_ij/2
  double printed_damping = 0.0;     // 1: tangential damping of the motion of the centres alone, eq. 4 as printed

  bool spring() const { return hooke > 0.0; }
  bool has_friction() const { return mu > 0.0; }
  double cutoff_ratio() const { return spring() ? 1.0 : cutoff; }    // r0/sigma_ij
  int integer_power() const { return index == std::floor(index) && index < 1.0e6 ? static_cast<int>(index) + 1 : 0; }

  // elastic force at distance r of a pair with sigma_ij = radsum
  double elastic(double r, double radsum) const
  {
    return spring() ? hooke * (radsum - r) : force * std::pow(radsum / r, index + 1.0);
  }

  // its potential, zero at r0
  double potential(double r, double radsum) const
  {
    if (spring()) return 0.5 * hooke * (radsum - r) * (radsum - r);
    return force * radsum / index * (std::pow(radsum / r, index) - std::pow(cutoff, -index));
  }

  // energy in the tangential displacement xi_t: integral of eq. 5 at fixed r; rest = 1 - |xi_t|/dmax
  double tangential_energy(double elastic, double depth, double xi_t) const
  {
    const double largest = alpha * mu * depth, rest = std::max(0.0, 1.0 - std::fabs(xi_t) / largest);
    return mu * elastic * largest * (1.0 - rest - 0.4 * (1.0 - rest * rest * std::sqrt(rest)));
  }
};

/* The contact history of the law; the history of a pair begins at r0. */
struct ContinuousHistory {
  // clang-format off
  enum {
    XI_T,       // tangential displacement xi_t (d of B97)
    FT,         // tangential force of the last evaluation, elastic and viscous
    VN,         // dr/dt in the middle of the step that ended at the last evaluation
    VT,         // the velocity that tangential damping acts on, likewise
    FN_DAMP,    // viscous normal force of the last evaluation
    COUNT
  };
  static constexpr HistoryColumn columns[COUNT] = {
      {"xi_t", HistoryColumn::SPRING},
      {"ft", HistoryColumn::FORCE},
      {"vn", HistoryColumn::VN},
      {"vt", HistoryColumn::VT},
      {"fn_damp", HistoryColumn::FORCE},
  };
  // clang-format on
};

/* power[k] = base[k]^exponent by repeated squaring of the whole block */
DISC_INLINE void raise(double *__restrict power, double *__restrict base, unsigned exponent, int count)
{
  for (int k = 0; k < count; k++)
    power[k] = 1.0;
  for (; exponent; exponent >>= 1) {
    if (exponent & 1)
      for (int k = 0; k < count; k++)
        power[k] *= base[k];
    for (int k = 0; k < count; k++)
      base[k] *= base[k];
  }
}

/* The law as pair_loop() wants it.  The constant of a pair is sqrt(m), m = 2 m* the mass that its damping is made with.

   xi_t grows by v_t dt and is held at dmax where it would exceed it; a pair beyond r0 has dmax = 0, which empties it.
   k_T diverges as r -> r0 (eq. 7): there C_T is limited to what stops the sliding of the two surfaces within a step, a
   third of m* over dt for discs, since a larger one would reverse it.

   SECOND: second order in the step, but for what that divergence leaves.  Dampers act on velocities extrapolated from
   the middles of this step, which ends here, and the one before to the end of this one; xi_t grows by the velocity in
   the middle of the step, seen in the middle of the rotation of n; a pair that crosses r0 within a step gets the
   contact-onset correction.  Without SECOND the mean velocity of the step stands for that at its end, as in B97
   (eqs. 9-12): first order.

   The work that F_t takes from the grains is the mean of its last and its present value times the slip, as the kicks of
   the scheme have it; what is not dissipated in the damper counts as dissipated_sliding, what xi_t stores included. */
template <bool SECOND_, bool SPRING, bool FRICTION_> struct Continuous {
  static constexpr bool SECOND = SECOND_, DAMPING = true, FRICTION = FRICTION_, ROLLING = false;
  using H = ContinuousHistory;
  ContinuousLaw law;

  struct Sliding {    // of a block: v_t in the middle of the step; at its end, as the damper sees it; the damping force
    alignas(64) double vt_mid[BLOCK], vt_end[BLOCK], ft_damp[BLOCK];
  };
  struct Tangential {    // force of a pair
    double elastic, damping;
    double sum() const { return elastic + damping; }
  };

  // ---- the terms, as forces of i on j ----

  // viscous normal force -C_N vn, C_N = 2 z sqrt(m k)
  static DISC_INLINE double normal_damping(double critical_ratio, double sqrt_m, double stiffness, double vn)
  {
    return -critical_ratio * sqrt_m * std::sqrt(stiffness) * vn;
  }

  // the largest C_T per m: a third of m* over dt
  static DISC_INLINE double damping_limit(double dt) { return dt > 0.0 ? 1.0 / (6.0 * dt) : 1.0e300; }

  /* F_t = -sign(xi_t) mu F_ne [1 - (1 - |xi_t|/dmax)^(3/2)] - C_T vt (eqs. 4 to 8) of a pair with depth = r0 - r;
     xi_t grows by dxi and is held at dmax = alpha mu depth. */
  DISC_INLINE Tangential tangential(double depth, double fn_elastic, double sqrt_m, double largest_damping, double vt,
                                    double dxi, double &xi_t) const
  {
    const double safe_depth = depth > 1.0e-300 ? depth : 1.0e-300, inverse_depth = 1.0 / safe_depth;
    const double slope = law.alpha * law.mu, xi_max = depth > 0.0 ? slope * safe_depth : 0.0;
    xi_t = clamp(xi_t + dxi, xi_max);
    const double to_limit = 1.0 - std::fabs(xi_t) * inverse_depth * (1.0 / slope);
    const double rest = to_limit > 1.0e-12 ? to_limit : 0.0, root = std::sqrt(rest);    // 1 - |xi_t|/dmax; 0: held
    const double critical = 2.0 * law.damping * sqrt_m * std::sqrt(1.5 / law.alpha * fn_elastic * inverse_depth * root);
    const double limit = sqrt_m * sqrt_m * largest_damping;
    return {-std::copysign(law.mu * fn_elastic * (1.0 - rest * root), xi_t),
            -(critical < limit ? critical : limit) * vt};
  }

  // ---- a block of pairs ----

  static DISC_INLINE void copy(double *__restrict to, const double *__restrict from)
  {
    for (int k = 0; k < BLOCK; k++)
      to[k] = from[k];
  }

  template <bool DISSIPATION>
  DISC_INLINE void compute_forces(const StepKinematics &step, Block &__restrict b, int count) const
  {
    const double cutoff = law.cutoff_ratio(), critical_ratio = 2.0 * law.damping;
    const double arm = 1.0 + law.printed_rotation, damped_rotation = 1.0 - law.printed_damping;
    const double hooke = law.hooke, strength = law.force, exponent = law.index + 1.0;
    const double dt = step.dt, extrapolation = step.extrapolation, largest_damping = damping_limit(dt);
    // copies on the stack: with this many arrays the compiler gives up proving that they do not overlap
    alignas(64) double sqrt_m[BLOCK], xi_t[BLOCK], vn[BLOCK], ft[BLOCK], vt[BLOCK], fn_damp[BLOCK];
    copy(sqrt_m, b.pair_constant);
    copy(vn, b.history[H::VN]);
    copy(fn_damp, b.history[H::FN_DAMP]);
    if (FRICTION) {
      copy(xi_t, b.history[H::XI_T]);
      copy(ft, b.history[H::FT]);
      copy(vt, b.history[H::VT]);
    }
    alignas(64) double inverses[BLOCK], power[BLOCK], base[BLOCK];
    Sliding sliding;
    for (int k = 0; k < count; k++) {
      inverses[k] = 1.0 / std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
      base[k] = b.radsum[k] * inverses[k];
    }
    if (!SPRING) {
      if (const int integer = law.integer_power())
        raise(power, base, integer, count);
      else
        for (int k = 0; k < count; k++)
          power[k] = std::pow(base[k], exponent);
    }
    for (int k = 0; k < count; k++) {
      const double inverse = inverses[k], nx = b.bx[k] * inverse, ny = b.by[k] * inverse;
      const double r = nx * b.bx[k] + ny * b.by[k];
      const double depth = cutoff * b.radsum[k] - r, in_contact = depth > 0.0 ? 1.0 : 0.0;
      const double fn_elastic = in_contact * (SPRING ? hooke * (b.radsum[k] - r) : strength * power[k]);
      const double stiffness = SPRING ? in_contact * hooke : exponent * fn_elastic * inverse;
      const double un = nx * b.ux[k] + ny * b.uy[k], ut = nx * b.uy[k] - ny * b.ux[k];
      const double n_rotation = 0.5 * dt * inverse * ut;           // angle by which n turns in half a step
      const double vn_mid = SECOND ? un - n_rotation * ut : un;    // dr/dt in the middle of the step
      const double vn_end = SECOND ? vn_mid + extrapolation * (vn_mid - vn[k]) : un;
      if (SECOND) {
        vn[k] = vn_mid;
        b.vn_end[k] = vn_end;
        const double entered = depth + dt * vn_mid > 0.0 ? 0.0 : in_contact;
        b.contact_changed[k] = depth > dt * vn_end ? entered : in_contact;
      }
      const double damping = normal_damping(critical_ratio, sqrt_m[k], stiffness, vn_end);
      if (DISSIPATION) b.dissipated_viscous[k] = -0.5 * (fn_damp[k] + damping) * vn_mid * dt;
      fn_damp[k] = damping;
      const double overlap = b.radsum[k] - r, approach = -in_contact * vn_mid;
      b.overlap[k] = overlap > b.overlap[k] ? overlap : b.overlap[k];
      b.approach[k] = approach > b.approach[k] ? approach : b.approach[k];
      const double normal = fn_elastic + damping;
      double f_t = 0.0;
      if (FRICTION) {
        const double arm_per_radsum = arm / b.radsum[k];
        const double vt_centres = SECOND ? ut + n_rotation * un : ut;
        const double vt_rot = (SECOND ? r - 0.5 * dt * vn_mid : r) * arm_per_radsum * b.vt_rot[k];
        const double vt_mid = vt_centres - vt_rot, vt_damped = vt_centres - damped_rotation * vt_rot;
        const double vt_end = SECOND ? vt_damped + extrapolation * (vt_damped - vt[k]) : vt_damped;
        double xi = xi_t[k];
        const Tangential force = tangential(depth, fn_elastic, sqrt_m[k], largest_damping, vt_end, vt_mid * dt, xi);
        f_t = force.sum();
        xi_t[k] = xi;
        if (SECOND) {
          vt[k] = vt_damped;
          sliding.vt_mid[k] = vt_mid;
          sliding.vt_end[k] = vt_end;
          sliding.ft_damp[k] = force.damping;
        }
        if (DISSIPATION) {
          const double viscous = -force.damping * (vt_end + (vt_mid - vt_damped)) * dt;
          b.dissipated_viscous[k] += viscous;
          b.dissipated_sliding[k] = -0.5 * (ft[k] + f_t) * vt_mid * dt - viscous;
        }
        ft[k] = f_t;
        b.tangential[k] = in_contact * r * arm_per_radsum * f_t;
      }
      b.fx[k] = normal * nx - f_t * ny;
      b.fy[k] = normal * ny + f_t * nx;
    }
    copy(b.history[H::FN_DAMP], fn_damp);
    if (SECOND) copy(b.history[H::VN], vn);
    if (FRICTION) {
      copy(b.history[H::XI_T], xi_t);
      copy(b.history[H::FT], ft);
      if (SECOND) copy(b.history[H::VT], vt);
    }
    if (SECOND && any(b.contact_changed, count))
      for (int k = 0; k < count; k++)
        if (b.contact_changed[k] != 0.0) correct_contact_onset<DISSIPATION>(dt, sliding, b, k);
  }

  /* Pair k came within r0 in the step that ends here (fraction q of the step in contact), or will leave it in the next
     one (fraction q_next of that step).  The tangential damping begins like one over the root of the time since r0: its
     mean over that time is twice its present value, so that 2 q - 1/2 of it is missing. */
  template <bool DISSIPATION>
  DISC_INLINE void correct_contact_onset(double dt, const Sliding &sliding, Block &__restrict b, int k) const
  {
    const double r = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]), nx = b.bx[k] / r, ny = b.by[k] / r;
    const double vn_mid = b.history[H::VN][k], vn_end = b.vn_end[k];
    const double depth = law.cutoff_ratio() * b.radsum[k] - r, depth_before = depth + dt * vn_mid;
    const bool entered = depth_before <= 0.0;
    const double q = entered ? depth / (depth - depth_before) : 1.0;
    const double missing_next = depth <= dt * vn_end ? missing_share(depth / (dt * vn_end)) : 0.0;
    const double missing = missing_next + (entered ? missing_share(q) : 0.0);
    const double fn_onset = SPRING ? 0.0 : law.elastic(law.cutoff_ratio(), 1.0);    // elastic force at r0
    double &fn_damp = b.history[H::FN_DAMP][k];
    const double added_damping = missing * fn_damp, added_normal = missing * fn_onset + added_damping;
    double added_tangential = 0.0;
    fn_damp += added_damping;
    if (DISSIPATION) b.dissipated_viscous[k] -= 0.5 * added_damping * vn_mid * dt;
    if (FRICTION) {
      const double fn_elastic = law.elastic(r, b.radsum[k]), vt_mid = sliding.vt_mid[k], vt_end = sliding.vt_end[k];
      double &ft = b.history[H::FT][k], &xi_t = b.history[H::XI_T][k];
      Tangential force = {ft - sliding.ft_damp[k], sliding.ft_damp[k]};
      if (entered) {
        xi_t = 0.0;
        force = tangential(depth, fn_elastic, b.pair_constant[k], damping_limit(dt), vt_end, vt_mid * q * dt, xi_t);
      }
      const double damping_share = 1.0 + missing_next + (entered ? 2.0 * q - 0.5 : 0.0);
      added_tangential = (1.0 + missing) * force.elastic + damping_share * force.damping - ft;
      if (DISSIPATION) {
        const double viscous = -(damping_share * force.damping - sliding.ft_damp[k]) * vt_end * dt;
        b.dissipated_viscous[k] += viscous;
        b.dissipated_sliding[k] -= 0.5 * added_tangential * vt_mid * dt + viscous;
      }
      ft += added_tangential;
      b.tangential[k] += (1.0 + law.printed_rotation) * r / b.radsum[k] * added_tangential;
    }
    b.fx[k] += added_normal * nx - added_tangential * ny;
    b.fy[k] += added_normal * ny + added_tangential * nx;
  }
};

}    // namespace disc

#endif
