/* SPDX-License-Identifier: GPL-2.0-or-later
   The cohesive law of Gilabert, Roux, Castellanos, PRE 75, 011303 (2007) ("G07"), sec. II B, for one pair of discs.

   Signs as in sweep.h; h < 0 is an overlap. */

#ifndef DISC_KERNELS_COHESIVE_H
#define DISC_KERNELS_COHESIVE_H

#include "sweep.h"

#include <cmath>

namespace disc
{

struct CohesiveLaw {
  double kn = 0.0;       // normal stiffness K_N [force/length], > 0
  double kt = 0.0;       // tangential stiffness K_T [force/length], > 0 with friction
  double zeta = 0.0;     // fraction of the critical damping (eq. 6), >= 0
  double mu = 0.0;       // friction coefficient (eq. 8), >= 0
  double f0 = 0.0;       // largest attraction F0 [force], >= 0
  double d0 = 0.0;       // range of the attraction D0 [length], > 0 with F0 > 0
  double kr = 0.0;       // rolling stiffness K_r [force length], > 0 with rolling resistance
  double mur = 0.0;      // rolling friction mu_r [length] (eq. 10), >= 0
  double zetat = 0.0;    // fractions of the critical damping of the tangential and the rolling spring; not in G07, >= 0
  double zetar = 0.0;

  bool damping() const { return zeta > 0.0; }
  bool cohesion() const { return f0 > 0.0; }
  bool friction() const { return mu > 0.0; }
  bool rolling() const { return mur > 0.0; }
  bool dashpots() const { return (zetat > 0.0 && friction()) || (zetar > 0.0 && rolling()); }
  double range() const { return cohesion() ? d0 : 0.0; }

  // critical damping sqrt(4 K_N m*), m* = m_i m_j/(m_i + m_j); eta_ij of eq. 6 is zeta times it
  double viscosity(double mi, double mj) const { return std::sqrt(4.0 * kn * mi * mj / (mi + mj)); }

  // attraction N_a <= 0: -F0 (1 - h/D0) in the tail (eq. 4), -F0 in contact (eq. 5)
  double attraction(double h) const { return h >= range() ? 0.0 : h < 0.0 ? -f0 : -f0 * (1.0 - h / d0); }

  // potential of the attraction, zero at h = D0: -F0 (D0 - h)^2/(2 D0) in the tail, -F0 D0/2 + F0 h in contact
  double adhesive_energy(double h) const
  {
    if (h >= range()) return 0.0;
    return h < 0.0 ? f0 * (h - 0.5 * d0) : -0.5 * f0 * (d0 - h) * (d0 - h) / d0;
  }
};

/* The law as sweep() wants it.  A term that a scene does not use is a template flag, so that it costs nothing.

   SECOND: second order in the step.  Dampers act on the velocity extrapolated from the middles of this step and the
   last one to its end; displacements grow by the velocity in the middle of the step, seen in the middle of the turn of
   n; and a contact that closes or opens within a step feels its damper, and stretches its springs, for its share of it.
   Without SECOND the mean velocity of the step stands for that at its end, as in the velocity Verlet of LAMMPS: first
   order.

   DASHPOTS, which G07 has not, let a packing come to rest whose springs would ring for ever: a dashpot beside the
   tangential and the rolling spring, T_v = -gamma_t d(du)/dt, M_v = -gamma_r d(dtheta)/dt.  They resist the elastic
   displacement alone, so that nothing that rolls, slides or flies is slowed.  gamma is zetat or zetar times the
   critical damping sqrt(4 K_T m*) and sqrt(4 K_r I*), with I* = m* (R_i + R_j)^2/8, that of equal discs.

   The dissipated energy is what the kicks of the scheme take: over a step the mean of the viscous forces at its
   beginning and at its end times the distance passed, the whole of it also where a slider gives way. */
template <bool SECOND_, bool DAMPING_, bool COHESION_, bool FRICTION_, bool ROLLING_, bool DASHPOTS_ = false>
struct Cohesive {
  static constexpr bool SECOND = SECOND_, COHESION = COHESION_, FRICTION = FRICTION_, ROLLING = ROLLING_,
                        DASHPOTS = DASHPOTS_ && (FRICTION || ROLLING), DAMPING = DAMPING_ || DASHPOTS;
  static constexpr bool JUMPS = SECOND && (DAMPING || FRICTION || ROLLING);    // something sets in at contact
  CohesiveLaw law;

  /* The Coulomb and rolling limits hold for the elastic repulsion alone (eqs. 8, 10): neither the viscous part nor F0
     enters.  An open contact has a limit of zero, which empties its springs. */
  template <bool ACCOUNT> DISC_INLINE void respond(const Motion &motion, Block &__restrict b, int count) const
  {
    const double kn = law.kn, kt = law.kt, kr = law.kr, f0 = law.f0, d0 = law.d0, dt = motion.dt, ahead = motion.ahead;
    const double sliding_limit = FRICTION ? law.mu / law.kt : 0.0, rolling_limit = ROLLING ? law.mur / law.kr : 0.0;
    const double tail = COHESION ? law.f0 / law.d0 : 0.0;
    const double zeta = law.zeta, range = law.range();
    const double gamma_t = DASHPOTS && FRICTION && dt > 0.0 ? law.zetat * std::sqrt(kt / kn) / dt : 0.0;
    const double gamma_r = DASHPOTS && ROLLING && dt > 0.0 ? law.zetar * std::sqrt(0.125 * kr / kn) / dt : 0.0;
    const double *const __restrict eta = b.eta;
    double *const __restrict stretch = b.stretch, *const __restrict rotation = b.rotation;
    double *const __restrict speed = b.speed, *const __restrict viscous = b.viscous;
    double *const __restrict viscous_t = b.viscous_t, *const __restrict viscous_r = b.viscous_r;
    for (int k = 0; k < count; k++) {
      const double distance = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
      const double inverse = 1.0 / distance;
      const double nx = b.bx[k] * inverse, ny = b.by[k] * inverse;
      const double h = distance - b.touch[k];
      const double closed = h < 0.0 ? 1.0 : 0.0;
      const double elastic = kn * (h < 0.0 ? -h : 0.0);
      double normal = elastic, tangential = 0.0;
      const double un = nx * b.ux[k] + ny * b.uy[k], ut = nx * b.uy[k] - ny * b.ux[k];
      const double turn = 0.5 * dt * inverse * ut;                          // of n in half a step
      const double middle = SECOND ? un - turn * ut : un;                   // d|b|/dt in the middle of the step
      if (JUMPS) b.crossed[k] = h * (h - dt * middle) < 0.0 ? 1.0 : 0.0;    // the gap changed its sign
      if (DAMPING) {
        const double vn = SECOND ? middle + ahead * (middle - speed[k]) : un;
        if (SECOND) {
          speed[k] = middle;
          b.receding[k] = vn;
        }
        const double damper = -zeta * eta[k] * vn * closed;
        if (ACCOUNT) b.lost_viscous[k] = -0.5 * (viscous[k] + damper) * middle * dt;
        viscous[k] = damper;
        normal += damper;
      }
      if (COHESION) normal -= h < 0.0 ? f0 : h < d0 ? f0 - tail * h : 0.0;
      if (FRICTION) {
        const double passed = ((SECOND ? ut + turn * un : ut) - b.surface[k]) * dt;
        const double kept = slide<ACCOUNT>(stretch[k], passed, sliding_limit * elastic, kt, b.lost_sliding[k]);
        tangential = -kt * kept;
        if (DASHPOTS) {
          const double dashpot = -gamma_t * eta[k] * (kept - stretch[k]) * closed;
          if (ACCOUNT) b.lost_viscous[k] -= 0.5 * (viscous_t[k] + dashpot) * passed;
          viscous_t[k] = dashpot;
          tangential += dashpot;
        }
        stretch[k] = kept;
        b.tangential[k] = tangential;
      }
      if (ROLLING) {
        const double turned = b.spin[k] * dt;
        const double kept = slide<ACCOUNT>(rotation[k], turned, rolling_limit * elastic, kr, b.lost_rolling[k]);
        double moment = -kr * kept;
        if (DASHPOTS) {
          const double dashpot = -gamma_r * b.touch[k] * eta[k] * (kept - rotation[k]) * closed;
          if (ACCOUNT) b.lost_viscous[k] -= 0.5 * (viscous_r[k] + dashpot) * turned;
          viscous_r[k] = dashpot;
          moment += dashpot;
        }
        rotation[k] = kept;
        b.moment[k] = moment;
      }
      b.overlap[k] = -h > b.overlap[k] ? -h : b.overlap[k];
      const double approach = h < range ? -middle : 0.0;
      b.approach[k] = approach > b.approach[k] ? approach : b.approach[k];
      b.fx[k] = normal * nx - tangential * ny;
      b.fy[k] = normal * ny + tangential * nx;
    }
    if (JUMPS) share_crossings<ACCOUNT>(dt, b, count);
  }

  /* Contacts that closed or opened in the step that ends here.  The scheme halves a force that jumps between two steps:
     a damper that was on for a part of the step is due that part instead, and springs grow for that part only.  Such
     contacts are rare: found by the blockful, mended one by one. */
  template <bool ACCOUNT> DISC_INLINE void share_crossings(double dt, Block &__restrict b, int count) const
  {
    alignas(64) double any[LANES] = {};
    add(any, b.crossed, count);
    if (total(any) == 0.0) return;
    for (int k = 0; k < count; k++) {
      if (b.crossed[k] == 0.0) continue;
      const double distance = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
      const double nx = b.bx[k] / distance, ny = b.by[k] / distance, h = distance - b.touch[k];
      const double un = nx * b.ux[k] + ny * b.uy[k], ut = nx * b.uy[k] - ny * b.ux[k];
      const double turn = 0.5 * dt * ut / distance, before = h - dt * (un - turn * ut);
      const bool entered = h < 0.0;
      const double within = (entered ? h : before) / -std::fabs(h - before);    // share of the step in contact
      double normal = 0.0, tangential = 0.0;                                    // what is added
      if (DAMPING) {
        const double vn = b.receding[k];
        normal = -law.zeta * b.eta[k] * vn * (within - 0.5);
        b.viscous[k] += normal;
        if (ACCOUNT) b.lost_viscous[k] -= 0.5 * normal * (un - turn * ut) * dt;
      }
      const double elastic = -law.kn * h;
      if (FRICTION && entered) {
        const double passed = dt * (ut + turn * un - b.surface[k]), limit = law.mu / law.kt * elastic;
        b.stretch[k] = slide<ACCOUNT>(0.0, within * passed, limit, law.kt, b.lost_sliding[k]);
        tangential = -law.kt * b.stretch[k] - b.tangential[k];
        b.tangential[k] += tangential;
        if (DASHPOTS) {    // they act from the next step on
          if (ACCOUNT) b.lost_viscous[k] += 0.5 * b.viscous_t[k] * passed;
          b.viscous_t[k] = 0.0;
        }
      }
      if (ROLLING && entered) {
        const double turned = dt * b.spin[k], limit = law.mur / law.kr * elastic;
        b.rotation[k] = slide<ACCOUNT>(0.0, within * turned, limit, law.kr, b.lost_rolling[k]);
        b.moment[k] = -law.kr * b.rotation[k];
        if (DASHPOTS) {
          if (ACCOUNT) b.lost_viscous[k] += 0.5 * b.viscous_r[k] * turned;
          b.viscous_r[k] = 0.0;
        }
      }
      b.fx[k] += normal * nx - tangential * ny;
      b.fy[k] += normal * ny + tangential * nx;
    }
  }
};

}    // namespace disc

#endif
