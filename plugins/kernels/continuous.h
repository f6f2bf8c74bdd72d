/* SPDX-License-Identifier: GPL-2.0-or-later
   The continuous law of Baxter, Tuzun, Burnell, Heyes, PRE 55, 3546 (1997) ("B97"), sec. II, for pairs of discs.

   Signs as in sweep.h. */

#ifndef DISC_KERNELS_CONTINUOUS_H
#define DISC_KERNELS_CONTINUOUS_H

#include "sweep.h"

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
  bool friction() const { return mu > 0.0; }
  double reach() const { return spring() ? 1.0 : cutoff; }    // r0/sigma_ij
  int whole_power() const { return index == std::floor(index) && index < 1.0e6 ? static_cast<int>(index) + 1 : 0; }

  // elastic force at distance r of a pair with sigma_ij = touch
  double elastic(double r, double touch) const
  {
    return spring() ? hooke * (touch - r) : force * std::pow(touch / r, index + 1.0);
  }

  // its potential, zero at r0
  double potential(double r, double touch) const
  {
    if (spring()) return 0.5 * hooke * (touch - r) * (touch - r);
    return force * touch / index * (std::pow(touch / r, index) - std::pow(cutoff, -index));
  }

  // energy in the tangential displacement d: integral of eq. 5 at fixed r; x = |d|/dmax
  double tangential_energy(double elastic, double depth, double d) const
  {
    const double largest = alpha * mu * depth, rest = std::max(0.0, 1.0 - std::fabs(d) / largest);
    return mu * elastic * largest * (1.0 - rest - 0.4 * (1.0 - rest * rest * std::sqrt(rest)));
  }
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

/* The law as sweep() wants it.  Of a pair, `eta` is sqrt(m), m = 2 m* the mass that its damping is made with; `stretch`
   is d, `rotation` the whole T of the last evaluation.

   d advances by v_t dt and is held at dmax where it would exceed it; a pair beyond r0 has dmax = 0, which empties it.
   k_T diverges as r -> r0 (eq. 7): there C_T is limited to what stops the sliding of the two surfaces within a step, a
   third of m* over dt for discs, since a larger one would reverse it.

   SECOND: second order in the step, but for what that divergence leaves.  Dampers act on velocities extrapolated from
   the middles of this step and the last one to its end; d grows by the velocity in the middle of the step, seen in the
   middle of the turn of n; a pair that crosses r0 within a step feels what jumps there, and stretches d, for its share
   of it.  Without SECOND the mean velocity of the step stands for that at its end, as in B97 (eqs. 9-12): first order.

   The work that T takes from the grains is the mean of its last and its present value times the slip, as the kicks of
   the scheme have it; what is not lost in the damper counts as lost_sliding, what is stored in d included. */
template <bool SECOND_, bool SPRING, bool FRICTION_> struct Continuous {
  static constexpr bool SECOND = SECOND_, DAMPING = true, FRICTION = FRICTION_, ROLLING = false;
  ContinuousLaw law;

  struct Slip {    // of a block: velocity in the middle of the step; at its end, as the damper sees it; its force
    alignas(64) double middle[BLOCK], end[BLOCK], drag[BLOCK];
  };

  // T_e and the drag on the velocity `end`, for d = old + increment, held at dmax
  DISC_INLINE double rub(double depth, double elastic, double eta, double most, double increment, double end, double &d,
                         double &drag) const
  {
    const double room = depth > 1.0e-300 ? depth : 1.0e-300, shallow = 1.0 / room;
    const double slope = law.alpha * law.mu, largest = depth > 0.0 ? slope * room : 0.0;
    const double trial = d + increment, above = trial < -largest ? -largest : trial;
    const double kept = above > largest ? largest : above;
    const double loaded = 1.0 - std::fabs(kept) * shallow * (1.0 / slope),
                 rest = loaded > 1.0e-12 ? loaded : 0.0;    // held
    const double root = std::sqrt(rest);
    const double critical = 2.0 * law.damping * eta * std::sqrt(1.5 / law.alpha * elastic * shallow * root);
    const double limit = eta * eta * most;
    drag = -(critical < limit ? critical : limit) * end;
    d = kept;
    return -std::copysign(law.mu * elastic * (1.0 - rest * root), kept);
  }

  static DISC_INLINE void copy(double *__restrict to, const double *__restrict from)
  {
    for (int k = 0; k < BLOCK; k++)
      to[k] = from[k];
  }

  static DISC_INLINE double most(double dt) { return dt > 0.0 ? 1.0 / (6.0 * dt) : 1.0e300; }

  template <bool ACCOUNT> DISC_INLINE void respond(const Motion &motion, Block &__restrict b, int count) const
  {
    const double reach = law.reach(), ratio = 2.0 * law.damping;
    const double arm = 1.0 + law.printed_rotation, rolls = 1.0 - law.printed_damping;
    const double hooke = law.hooke, strength = law.force, exponent = law.index + 1.0;
    const double dt = motion.dt, ahead = motion.ahead, limit = most(dt);
    // copies on the stack: with this many arrays the compiler gives up proving that they do not overlap
    alignas(64) double eta[BLOCK], stretch[BLOCK], speed[BLOCK], force[BLOCK], sideways[BLOCK], viscous[BLOCK];
    copy(eta, b.eta);
    copy(speed, b.speed);
    copy(viscous, b.viscous);
    if (FRICTION) {
      copy(stretch, b.stretch);
      copy(force, b.rotation);
      copy(sideways, b.sideways);
    }
    alignas(64) double inverses[BLOCK], power[BLOCK], base[BLOCK];
    Slip slip;
    for (int k = 0; k < count; k++) {
      inverses[k] = 1.0 / std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
      base[k] = b.touch[k] * inverses[k];
    }
    if (!SPRING) {
      if (const int whole = law.whole_power())
        raise(power, base, whole, count);
      else
        for (int k = 0; k < count; k++)
          power[k] = std::pow(base[k], exponent);
    }
    for (int k = 0; k < count; k++) {
      const double inverse = inverses[k], nx = b.bx[k] * inverse, ny = b.by[k] * inverse;
      const double r = nx * b.bx[k] + ny * b.by[k];
      const double depth = reach * b.touch[k] - r, within = depth > 0.0 ? 1.0 : 0.0;
      const double elastic = within * (SPRING ? hooke * (b.touch[k] - r) : strength * power[k]);
      const double stiffness = SPRING ? within * hooke : exponent * elastic * inverse;
      const double un = nx * b.ux[k] + ny * b.uy[k], ut = nx * b.uy[k] - ny * b.ux[k];
      const double turn = 0.5 * dt * inverse * ut;           // of n in half a step
      const double middle = SECOND ? un - turn * ut : un;    // dr/dt in the middle of the step
      const double vn = SECOND ? middle + ahead * (middle - speed[k]) : un;
      if (SECOND) {
        speed[k] = middle;
        b.receding[k] = vn;
        const double entered = depth + dt * middle > 0.0 ? 0.0 : within;
        b.crossed[k] = depth > dt * vn ? entered : within;
      }
      const double damper = -ratio * eta[k] * std::sqrt(stiffness) * vn;
      if (ACCOUNT) b.lost_viscous[k] = -0.5 * (viscous[k] + damper) * middle * dt;
      viscous[k] = damper;
      const double overlap = b.touch[k] - r, approach = -within * middle;
      b.overlap[k] = overlap > b.overlap[k] ? overlap : b.overlap[k];
      b.approach[k] = approach > b.approach[k] ? approach : b.approach[k];
      const double normal = elastic + damper;
      double tangential = 0.0;
      if (FRICTION) {
        const double per_touch = arm / b.touch[k];
        const double centres = SECOND ? ut + turn * un : ut;
        const double turning = (SECOND ? r - 0.5 * dt * middle : r) * per_touch * b.surface[k];
        const double vt = centres - turning, damped = centres - rolls * turning;
        const double end = SECOND ? damped + ahead * (damped - sideways[k]) : damped;
        double d = stretch[k], drag;
        tangential = rub(depth, elastic, eta[k], limit, vt * dt, end, d, drag);
        tangential += drag;
        stretch[k] = d;
        if (SECOND) {
          sideways[k] = damped;
          slip.middle[k] = vt;
          slip.end[k] = end;
          slip.drag[k] = drag;
        }
        if (ACCOUNT) {
          const double dragged = -drag * (end + (vt - damped)) * dt;
          b.lost_viscous[k] += dragged;
          b.lost_sliding[k] = -0.5 * (force[k] + tangential) * vt * dt - dragged;
        }
        force[k] = tangential;
        b.tangential[k] = within * r * per_touch * tangential;
      }
      b.fx[k] = normal * nx - tangential * ny;
      b.fy[k] = normal * ny + tangential * nx;
    }
    copy(b.viscous, viscous);
    if (SECOND) copy(b.speed, speed);
    if (FRICTION) {
      copy(b.stretch, stretch);
      copy(b.rotation, force);
      if (SECOND) copy(b.sideways, sideways);
    }
    if (SECOND) share_crossings<ACCOUNT>(dt, slip, b, count);
  }

  /* As of the cohesive law: pairs that came within r0 in the step that ends here, or will leave in the next one.  The
     scheme halves what jumps between two steps; due is the share of the step.  The drag begins like one over the root
     of the time since r0: its mean over that time is twice its present value. */
  template <bool ACCOUNT>
  DISC_INLINE void share_crossings(double dt, const Slip &slip, Block &__restrict b, int count) const
  {
    alignas(64) double any[LANES] = {};
    add(any, b.crossed, count);
    if (total(any) == 0.0) return;
    const double edge = SPRING ? 0.0 : law.elastic(law.reach(), 1.0);
    for (int k = 0; k < count; k++) {
      if (b.crossed[k] == 0.0) continue;
      const double r = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]), nx = b.bx[k] / r, ny = b.by[k] / r;
      const double depth = law.reach() * b.touch[k] - r, vn = b.receding[k], before = depth + dt * b.speed[k];
      const bool entered = before <= 0.0;
      const double within = entered ? depth / (depth - before) : 1.0;
      const double leaving = depth <= dt * vn ? depth / (dt * vn) - 0.5 : 0.0;
      const double part = leaving + (entered ? within - 0.5 : 0.0);
      const double damper = part * b.viscous[k], normal = part * edge + damper;
      double tangential = 0.0;    // what is added
      b.viscous[k] += damper;
      if (ACCOUNT) b.lost_viscous[k] -= 0.5 * damper * b.speed[k] * dt;
      if (FRICTION) {
        const double elastic = law.elastic(r, b.touch[k]), vt = slip.middle[k], end = slip.end[k];
        double drag = slip.drag[k], spring = b.rotation[k] - drag;
        if (entered) {
          b.stretch[k] = 0.0;
          spring = rub(depth, elastic, b.eta[k], most(dt), vt * within * dt, end, b.stretch[k], drag);
        }
        const double due = 1.0 + leaving + (entered ? 2.0 * within - 0.5 : 0.0);
        tangential = (1.0 + part) * spring + due * drag - b.rotation[k];
        if (ACCOUNT) {
          const double dragged = -(due * drag - slip.drag[k]) * end * dt;
          b.lost_viscous[k] += dragged;
          b.lost_sliding[k] -= 0.5 * tangential * vt * dt + dragged;
        }
        b.rotation[k] += tangential;
        b.tangential[k] += (1.0 + law.printed_rotation) * r / b.touch[k] * tangential;
      }
      b.fx[k] += normal * nx - tangential * ny;
      b.fy[k] += normal * ny + tangential * nx;
    }
  }
};

}    // namespace disc

#endif
