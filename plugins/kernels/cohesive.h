/* SPDX-License-Identifier: GPL-2.0-or-later
   The cohesive law of Gilabert, Roux, Castellanos, PRE 75, 011303 (2007) ("G07"), sec. II B, for one pair of discs.

   Stateless: no engine, no loop, no memory beyond what is passed in.  Units are the caller's.  Signs: n points from i
   to j, t is n rotated by +90 degrees, h < 0 is an overlap, N > 0 repels, the force of i on j is N n + T t and the
   rolling moment of i on j is M.  A law term that a scene does not use is a template flag, so that it costs nothing. */

#ifndef DISC_KERNELS_COHESIVE_H
#define DISC_KERNELS_COHESIVE_H

#include <cmath>

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

struct Motion {      // relative motion at the contact, affine motion of the cell included
  double normal;     // v_n = n.(v_j - v_i), receding positive
  double tangent;    // v_t = t.(v_j - v_i) - R_i w_i - R_j w_j
  double spin;       // w_j - w_i
};

struct Springs {      // what a contact remembers; forgotten when it opens
  double stretch;     // elastic part du of the tangential displacement
  double rotation;    // elastic part dtheta of the relative rotation
};

struct Reaction {       // what acts on j because of i
  double elastic;       // N_e = -K_N h >= 0
  double viscous;       // N_v = -eta v_n
  double tangential;    // T
  double moment;        // M
};

struct Loss {    // energy dissipated since the beginning
  double viscous = 0.0, sliding = 0.0, rolling = 0.0;
};

/* One slider: advance the elastic displacement, then return to the cone |displacement| <= limit.  The energy lost is
   the mean of the old and the new force times the slip, which closes the energy account to second order in the step. */
template <bool ACCOUNT> inline double slide(double old, double increment, double limit, double stiffness, double &lost)
{
  const double trial = old + increment;
  const double kept = std::fmin(std::fmax(trial, -limit), limit);
  if (ACCOUNT) lost += 0.5 * stiffness * (old + kept) * (trial - kept);
  return kept;
}

/* Contact (h < 0): advance the memory by dt and return the reaction.  The Coulomb and rolling limits hold for the
   elastic repulsion alone (eqs. 8, 10): neither the viscous part nor F0 enters. */
template <bool DAMPING, bool FRICTION, bool ROLLING, bool ACCOUNT>
inline Reaction contact(const CohesiveLaw &law, double eta, double h, const Motion &motion, double dt, Springs &springs,
                        Loss &loss)
{
  Reaction reaction{-law.kn * h, 0.0, 0.0, 0.0};
  if (DAMPING) {
    reaction.viscous = -eta * motion.normal;
    if (ACCOUNT) loss.viscous -= reaction.viscous * motion.normal * dt;
  }
  if (FRICTION) {
    springs.stretch =
        slide<ACCOUNT>(springs.stretch, motion.tangent * dt, law.mu * reaction.elastic / law.kt, law.kt, loss.sliding);
    reaction.tangential = -law.kt * springs.stretch;
  }
  if (ROLLING) {
    springs.rotation =
        slide<ACCOUNT>(springs.rotation, motion.spin * dt, law.mur * reaction.elastic / law.kr, law.kr, loss.rolling);
    reaction.moment = -law.kr * springs.rotation;
  }
  return reaction;
}

}    // namespace disc

#endif
