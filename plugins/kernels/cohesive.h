/* SPDX-License-Identifier: GPL-2.0-or-later
   The cohesive law of Gilabert, Roux, Castellanos, PRE 75, 011303 (2007) ("G07"), sec. II B, for one pair of discs.

   Stateless: no engine, no loop, no memory beyond what is passed in.  Units are the caller's.  Signs: n points from i
   to j, t is n rotated by +90 degrees, h < 0 is an overlap, N > 0 repels, the force of i on j is N n + T t and the
   rolling moment of i on j is M.  A law term that a scene does not use is a template flag, so that it costs nothing. */

#ifndef DISC_KERNELS_COHESIVE_H
#define DISC_KERNELS_COHESIVE_H

#include <cmath>

/* Compiled for several instruction sets, the widest that the machine has is taken when the library is loaded.  No set
   may contract a*b + c (-ffp-contract=off), so that all give the same bits. */
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__)
#define DISC_WIDEST __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define DISC_WIDEST
#endif

namespace disc
{

struct CohesiveLaw {
  double kn = 0.0;      // normal stiffness K_N [force/length], > 0
  double kt = 0.0;      // tangential stiffness K_T [force/length], > 0 with friction
  double zeta = 0.0;    // fraction of the critical damping (eq. 6), >= 0
  double mu = 0.0;      // friction coefficient (eq. 8), >= 0
  double f0 = 0.0;      // largest attraction F0 [force], >= 0
  double d0 = 0.0;      // range of the attraction D0 [length], > 0 with F0 > 0
  double kr = 0.0;      // rolling stiffness K_r [force length], > 0 with rolling resistance
  double mur = 0.0;     // rolling friction mu_r [length] (eq. 10), >= 0

  bool damping() const { return zeta > 0.0; }
  bool cohesion() const { return f0 > 0.0; }
  bool friction() const { return mu > 0.0; }
  bool rolling() const { return mur > 0.0; }
  double range() const { return cohesion() ? d0 : 0.0; }

  // eta_ij = zeta sqrt(4 K_N m*), m* = m_i m_j/(m_i + m_j) (eq. 6)
  double viscosity(double mi, double mj) const { return zeta * std::sqrt(4.0 * kn * mi * mj / (mi + mj)); }

  // attraction N_a <= 0: -F0 (1 - h/D0) in the tail (eq. 4), -F0 in contact (eq. 5)
  double attraction(double h) const { return !cohesion() ? 0.0 : h < 0.0 ? -f0 : -f0 * (1.0 - h / d0); }

  // potential of the attraction, zero at h = D0: -F0 (D0 - h)^2/(2 D0) in the tail, -F0 D0/2 + F0 h in contact
  double adhesive_energy(double h) const
  {
    if (!cohesion()) return 0.0;
    return h < 0.0 ? f0 * (h - 0.5 * d0) : -0.5 * f0 * (d0 - h) * (d0 - h) / d0;
  }
};

struct Springs {      // what a contact remembers; forgotten when it opens
  double stretch;     // elastic part du of the tangential displacement
  double rotation;    // elastic part dtheta of the relative rotation
};

struct Loss {    // energy dissipated since the beginning
  double viscous = 0.0, sliding = 0.0, rolling = 0.0;
};

/* Some pairs within reach, as arrays, so that one instruction works on several pairs. */
struct Block {
  static constexpr int SIZE = 32;
  // in
  double bx[SIZE], by[SIZE];        // branch vector from i to j
  double ux[SIZE], uy[SIZE];        // v_j - v_i, the affine motion of the cell included
  double surface[SIZE];             // R_i w_i + R_j w_j
  double spin[SIZE];                // w_j - w_i
  double touch[SIZE], eta[SIZE];    // R_i + R_j; viscosity
  // in and out
  double stretch[SIZE], rotation[SIZE];
  // out
  double fx[SIZE], fy[SIZE];    // force of i on j
  double tangential[SIZE], moment[SIZE], viscous[SIZE];
  double lost_viscous[SIZE], lost_sliding[SIZE], lost_rolling[SIZE];
};

/* One slider: advance the elastic displacement, then return to the cone |displacement| <= limit.  The energy lost is
   the mean of the old and the new force times the slip, which closes the energy account to second order in the step. */
template <bool ACCOUNT> inline double slide(double old, double increment, double limit, double stiffness, double &lost)
{
  const double trial = old + increment;
  const double above = trial < -limit ? -limit : trial;
  const double kept = above > limit ? limit : above;
  if (ACCOUNT) lost = 0.5 * stiffness * (old + kept) * (trial - kept);
  return kept;
}

/* Forces of the first `count` pairs of a block; contacts advance their springs by dt, distant pairs have none.  The
   Coulomb and rolling limits hold for the elastic repulsion alone (eqs. 8, 10): neither the viscous part nor F0 enters.
 */
template <bool DAMPING, bool COHESION, bool FRICTION, bool ROLLING, bool ACCOUNT>
DISC_WIDEST void respond(const CohesiveLaw &law, double dt, Block &__restrict b, int count)
{
  const double kn = law.kn, kt = law.kt, kr = law.kr, f0 = law.f0;
  const double sliding_limit = FRICTION ? law.mu / law.kt : 0.0, rolling_limit = ROLLING ? law.mur / law.kr : 0.0;
  const double tail = COHESION ? law.f0 / law.d0 : 0.0;
  for (int k = 0; k < count; k++) {
    const double distance = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
    const double nx = b.bx[k] / distance, ny = b.by[k] / distance;
    const double h = distance - b.touch[k];
    const double touching = !COHESION || h < 0.0 ? 1.0 : 0.0;
    const double elastic = -kn * h * touching;
    double normal = elastic, tangential = 0.0;
    if (DAMPING) {
      const double vn = nx * b.ux[k] + ny * b.uy[k];
      const double viscous = -b.eta[k] * vn * touching;
      b.viscous[k] = viscous;
      normal += viscous;
      if (ACCOUNT) b.lost_viscous[k] = -viscous * vn * dt;
    }
    if (COHESION) normal -= h < 0.0 ? f0 : f0 - tail * h;
    if (FRICTION) {
      const double vt = nx * b.uy[k] - ny * b.ux[k] - b.surface[k];
      const double kept = slide<ACCOUNT>(b.stretch[k], vt * dt, sliding_limit * elastic, kt, b.lost_sliding[k]);
      b.stretch[k] = kept;
      tangential = -kt * kept;
      b.tangential[k] = tangential;
    }
    if (ROLLING) {
      const double kept = slide<ACCOUNT>(b.rotation[k], b.spin[k] * dt, rolling_limit * elastic, kr, b.lost_rolling[k]);
      b.rotation[k] = kept;
      b.moment[k] = -kr * kept;
    }
    b.fx[k] = normal * nx - tangential * ny;
    b.fy[k] = normal * ny + tangential * nx;
  }
}

}    // namespace disc

#endif
