/* SPDX-License-Identifier: GPL-2.0-or-later
   The continuous law of Baxter, Tuzun, Burnell, Heyes, PRE 55, 3546 (1997) ("B97"), sec. II, for pairs of discs.

   Stateless: no engine, no memory beyond what is passed in.  Signs as in cohesive.h: n points from i to j, t is n
   rotated by +90 degrees, N > 0 repels, the force of i on j is N n + T t. */

#ifndef DISC_KERNELS_CONTINUOUS_H
#define DISC_KERNELS_CONTINUOUS_H

#include "cohesive.h"

#include <algorithm>

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

/* Some pairs within r0 of each other, as arrays, so that one instruction works on several pairs. */
struct ContinuousBlock {
  static constexpr int SIZE = 32;
  // in
  double bx[SIZE], by[SIZE];        // branch vector from i to j
  double ux[SIZE], uy[SIZE];        // v_j - v_i
  double surface[SIZE];             // R_i w_i + R_j w_j
  double touch[SIZE], eta[SIZE];    // sigma_ij; sqrt(m), m = 2 m* the mass that the pair's damping is made with
  double stretch[SIZE];             // in and out: d
  // out
  double fx[SIZE], fy[SIZE];    // force of i on j
  double torque[SIZE];          // T times lever arm per radius: the moment on i is -R_i torque, on j -R_j torque
  double viscous[SIZE], dragging[SIZE];    // viscous parts of N and T
  double lost_viscous[SIZE], lost_sliding[SIZE];
};

/* power[k] = base[k]^exponent by repeated squaring of the whole block */
DISC_WIDEST inline void raise(double *__restrict power, double *__restrict base, unsigned exponent, int count)
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

/* Forces of the first `count` pairs of a block; d advances by v_t dt and is held at dmax where it would exceed it.

   k_T diverges as r -> r0 (eq. 7): there C_T is limited to what stops the sliding of the two surfaces within a step,
   a third of m* over dt for discs, since a larger one would reverse it.  lost_sliding is the whole work that T_e takes
   from the grains, what is stored in d included. */
template <bool SPRING, bool FRICTION, bool ACCOUNT>
DISC_WIDEST void respond(const ContinuousLaw &law, double dt, ContinuousBlock &__restrict b, int count)
{
  const double reach = law.reach(), slope = law.alpha * law.mu, mu = law.mu, ratio = 2.0 * law.damping;
  const double arm = 1.0 + law.printed_rotation, rolls = 1.0 - law.printed_damping;
  const double hooke = law.hooke, strength = law.force, exponent = law.index + 1.0;
  const double most = 1.0 / (6.0 * dt), per_force = FRICTION ? 1.5 / law.alpha : 0.0;
  double power[ContinuousBlock::SIZE], base[ContinuousBlock::SIZE], distance[ContinuousBlock::SIZE];
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
    const double r = distance[k], nx = b.bx[k] / r, ny = b.by[k] / r;
    const double elastic = SPRING ? hooke * (b.touch[k] - r) : strength * power[k];
    const double stiffness = SPRING ? hooke : exponent * elastic / r;
    const double vn = nx * b.ux[k] + ny * b.uy[k];
    const double viscous = -ratio * b.eta[k] * std::sqrt(stiffness) * vn;
    b.viscous[k] = viscous;
    if (ACCOUNT) b.lost_viscous[k] = -viscous * vn * dt;
    const double normal = elastic + viscous;
    double tangential = 0.0;
    if (FRICTION) {
      const double depth = std::max(reach * b.touch[k] - r, 1.0e-300);
      const double largest = slope * depth, lever = arm * r / b.touch[k];
      const double sideways = nx * b.uy[k] - ny * b.ux[k], vt = sideways - lever * b.surface[k];
      const double old = b.stretch[k], trial = old + vt * dt;
      const double above = trial < -largest ? -largest : trial;
      const double kept = above > largest ? largest : above;
      const double rest = 1.0 - std::fabs(kept) / largest, root = std::sqrt(rest);
      const double spring = -std::copysign(mu * elastic * (1.0 - rest * root), kept);
      const double critical = ratio * b.eta[k] * std::sqrt(per_force * elastic / depth * root);
      const double limit = b.eta[k] * b.eta[k] * most;
      const double dragging = -(critical < limit ? critical : limit) * (sideways - rolls * lever * b.surface[k]);
      b.stretch[k] = kept;
      b.dragging[k] = dragging;
      tangential = spring + dragging;
      b.torque[k] = lever * tangential;
      if (ACCOUNT) {
        const double before = std::max(0.0, 1.0 - std::fabs(old) / largest);
        const double earlier = -std::copysign(mu * elastic * (1.0 - before * std::sqrt(before)), old);
        b.lost_sliding[k] = -0.5 * (spring + earlier) * vt * dt;
        b.lost_viscous[k] -= dragging * vt * dt;
      }
    }
    b.fx[k] = normal * nx - tangential * ny;
    b.fy[k] = normal * ny + tangential * nx;
  }
}

}    // namespace disc

#endif
