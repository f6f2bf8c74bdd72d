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
   is d, `rotation` the viscous part of T of this evaluation, for output.

   d advances by v_t dt and is held at dmax where it would exceed it; a pair beyond r0 has dmax = 0, which empties it.
   k_T diverges as r -> r0 (eq. 7): there C_T is limited to what stops the sliding of the two surfaces within a step, a
   third of m* over dt for discs, since a larger one would reverse it.  lost_sliding is the whole work that T_e takes
   from the grains, what is stored in d included. */
template <bool SPRING, bool FRICTION_> struct Continuous {
  static constexpr bool DAMPING = true, FRICTION = FRICTION_, ROLLING = false;
  ContinuousLaw law;

  template <bool ACCOUNT> DISC_INLINE void respond(const Motion &motion, Block &__restrict b, int count) const
  {
    const double reach = law.reach(), slope = law.alpha * law.mu, mu = law.mu, ratio = 2.0 * law.damping;
    const double arm = 1.0 + law.printed_rotation, rolls = 1.0 - law.printed_damping;
    const double hooke = law.hooke, strength = law.force, exponent = law.index + 1.0, dt = motion.dt;
    const double most = dt > 0.0 ? 1.0 / (6.0 * dt) : 1.0e300, per_force = FRICTION ? 1.5 / law.alpha : 0.0;
    const double *const __restrict eta = b.eta;
    double *const __restrict stretch = b.stretch, *const __restrict dragged = b.rotation;
    double *const __restrict viscous = b.viscous;
    alignas(64) double distance[BLOCK], power[BLOCK], base[BLOCK];
    for (int k = 0; k < count; k++) {
      distance[k] = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
      base[k] = b.touch[k] / distance[k];
    }
    if (!SPRING) {
      if (const int whole = law.whole_power())
        raise(power, base, whole, count);
      else
        for (int k = 0; k < count; k++)
          power[k] = std::pow(base[k], exponent);
    }
    for (int k = 0; k < count; k++) {
      const double r = distance[k], inverse = 1.0 / r, nx = b.bx[k] * inverse, ny = b.by[k] * inverse;
      const double depth = reach * b.touch[k] - r, within = depth > 0.0 ? 1.0 : 0.0;
      const double elastic = within * (SPRING ? hooke * (b.touch[k] - r) : strength * power[k]);
      const double stiffness = SPRING ? within * hooke : exponent * elastic * inverse;
      const double vn = nx * b.ux[k] + ny * b.uy[k];
      const double damper = -ratio * eta[k] * std::sqrt(stiffness) * vn;
      viscous[k] = damper;
      if (ACCOUNT) b.lost_viscous[k] = -damper * vn * dt;
      const double normal = elastic + damper;
      double tangential = 0.0;
      if (FRICTION) {
        const double room = depth > 1.0e-300 ? depth : 1.0e-300, largest = slope * room;
        const double lever = within > 0.0 ? arm * r / b.touch[k] : 0.0;
        const double sideways = nx * b.uy[k] - ny * b.ux[k], vt = sideways - lever * b.surface[k];
        const double old = stretch[k], trial = old + vt * dt;
        const double above = trial < -largest ? -largest : trial;
        const double kept = within * (above > largest ? largest : above);
        const double rest = 1.0 - std::fabs(kept) / largest, root = std::sqrt(rest);
        const double spring = -std::copysign(mu * elastic * (1.0 - rest * root), kept);
        const double critical = ratio * eta[k] * std::sqrt(per_force * elastic / room * root);
        const double limit = eta[k] * eta[k] * most;
        const double dragging = -(critical < limit ? critical : limit) * (sideways - rolls * lever * b.surface[k]);
        stretch[k] = kept;
        dragged[k] = dragging;
        tangential = spring + dragging;
        b.tangential[k] = lever * tangential;
        if (ACCOUNT) {
          const double share = 1.0 - std::fabs(old) / largest, before = share > 0.0 ? share : 0.0;
          const double earlier = -std::copysign(mu * elastic * (1.0 - before * std::sqrt(before)), old);
          b.lost_sliding[k] = -0.5 * (spring + earlier) * vt * dt;
          b.lost_viscous[k] -= dragging * vt * dt;
        }
      }
      b.fx[k] = normal * nx - tangential * ny;
      b.fy[k] = normal * ny + tangential * nx;
    }
  }
};

}    // namespace disc

#endif
