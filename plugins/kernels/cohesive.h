/* SPDX-License-Identifier: GPL-2.0-or-later
   The cohesive law of Gilabert, Roux, Castellanos, PRE 75, 011303 (2007) ("G07"), sec. II B, for one pair of discs.

   Signs as in pair_loop.h; h is the gap, h < 0 an overlap.  Words and symbols: docs/glossary.md. */

#ifndef DISC_KERNELS_COHESIVE_H
#define DISC_KERNELS_COHESIVE_H

#include "pair_loop.h"

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

  bool has_damping() const { return zeta > 0.0; }
  bool has_cohesion() const { return f0 > 0.0; }
  bool has_friction() const { return mu > 0.0; }
  bool has_rolling() const { return mur > 0.0; }
  bool has_dashpots() const { return (zetat > 0.0 && has_friction()) || (zetar > 0.0 && has_rolling()); }
  double cutoff_gap() const { return has_cohesion() ? d0 : 0.0; }    // gap up to which the law acts

  // critical damping gamma_crit = sqrt(4 K_N m*), m* = m_i m_j/(m_i + m_j); gamma_n (eta_ij of eq. 6) is zeta times it
  double critical_damping(double mi, double mj) const { return std::sqrt(4.0 * kn * mi * mj / (mi + mj)); }

  // attraction N_a <= 0: -F0 (1 - h/D0) in the tail (eq. 4), -F0 in contact (eq. 5)
  // for output; the kernel has attraction_size(), which rounds otherwise: do not merge
  double attraction(double h) const { return h >= cutoff_gap() ? 0.0 : h < 0.0 ? -f0 : -f0 * (1.0 - h / d0); }

  // potential of the attraction, zero at h = D0: -F0 (D0 - h)^2/(2 D0) in the tail, -F0 D0/2 + F0 h in contact
  double adhesive_energy(double h) const
  {
    if (h >= cutoff_gap()) return 0.0;
    return h < 0.0 ? f0 * (h - 0.5 * d0) : -0.5 * f0 * (d0 - h) * (d0 - h) / d0;
  }
};

/* The contact history of the law. */
struct CohesiveHistory {
  // clang-format off
  enum {
    XI_T,       // elastic tangential displacement xi_t (du of G07); zero unless in contact
    XI_R,       // elastic rolling displacement xi_r (dtheta of G07); zero unless in contact
    VN,         // d|b|/dt in the middle of the step that ended at the last evaluation
    FN_DAMP,    // viscous normal force of the last evaluation
    FT_DAMP,    // force of the tangential dashpot, likewise
    MR_DAMP,    // moment of the rolling dashpot, likewise
    COUNT
  };
  static constexpr HistoryColumn columns[COUNT] = {
      {"xi_t", HistoryColumn::SPRING},
      {"xi_r", HistoryColumn::SPRING, -1.0},
      {"vn", HistoryColumn::VN},
      {"fn_damp", HistoryColumn::FORCE},
      {"ft_damp", HistoryColumn::FORCE},
      {"mr_damp", HistoryColumn::FORCE, -1.0},
  };
  // clang-format on
};

/* The law as pair_loop() wants it.  A term that a scene does not use is a template flag, so that it costs nothing.

   SECOND: second order in the step.  Dampers act on the velocity extrapolated from the middles of this step, which ends
   here, and the one before to the end of this one; elastic displacements grow by the velocity in the middle of the
   step, seen in the middle of the rotation of n; and a contact that closes or opens within a step gets the
   contact-onset correction.  Without SECOND the mean velocity of the step stands for that at its end, as in the
   velocity Verlet of LAMMPS: first order.

   DASHPOTS, which G07 has not, let a packing come to rest whose springs would ring for ever: a dashpot beside the
   tangential and the rolling spring, -gamma_t d(xi_t)/dt and -gamma_r d(xi_r)/dt.  They resist the elastic displacement
   alone, so that nothing that rolls, slides or flies is slowed.  gamma is zetat or zetar times the critical damping
   sqrt(4 K_T m*) and sqrt(4 K_r I*), with I* = m* (R_i + R_j)^2/8, that of equal discs.  They are outside the limits of
   eqs. 8 and 10, and first order in the step.

   The dissipated energy is what the kicks of the scheme take: over a step the mean of the viscous forces at its
   beginning and at its end times the distance passed, the whole of it also where a spring is at its limit. */
template <bool SECOND_, bool DAMPING_, bool COHESION_, bool FRICTION_, bool ROLLING_, bool DASHPOTS_ = false>
struct Cohesive {
  // DAMPING with DASHPOTS even at zeta = 0: it initialises dissipated_viscous
  static constexpr bool SECOND = SECOND_, COHESION = COHESION_, FRICTION = FRICTION_, ROLLING = ROLLING_,
                        DASHPOTS = DASHPOTS_ && (FRICTION || ROLLING), DAMPING = DAMPING_ || DASHPOTS;
  // damper or springs set in at contact; repulsion and attraction are continuous
  static constexpr bool ONSET = SECOND && (DAMPING || FRICTION || ROLLING);
  using H = CohesiveHistory;
  CohesiveLaw law;

  /* The constants of a pass: the law, and what follows from it.  A local copy tells the compiler that no store into the
     block changes them. */
  struct Constants : CohesiveLaw {
    double range, slope;              // cutoff gap; F0/D0
    double dt, extrapolation;         // of the step
    double xi_t_limit, xi_r_limit;    // per elastic repulsion: mu/K_T, mu_r/K_r
    // gamma_t/(gamma_crit dt); gamma_r/(gamma_crit (R_i + R_j) dt); 0 where no time passes
    double gamma_t, gamma_r;
  };

  DISC_INLINE Constants constants(const StepKinematics &step) const
  {
    Constants c{law, 0.0, 0.0, step.dt, step.extrapolation, 0.0, 0.0, 0.0, 0.0};
    c.range = law.cutoff_gap();
    if (COHESION) c.slope = law.f0 / law.d0;
    if (FRICTION) c.xi_t_limit = law.mu / law.kt;
    if (ROLLING) c.xi_r_limit = law.mur / law.kr;
    if (DASHPOTS && FRICTION && c.dt > 0.0) c.gamma_t = law.zetat * std::sqrt(law.kt / law.kn) / c.dt;
    if (DASHPOTS && ROLLING && c.dt > 0.0) c.gamma_r = law.zetar * std::sqrt(0.125 * law.kr / law.kn) / c.dt;
    return c;
  }

  // ---- the terms, as forces of i on j ----

  // elastic repulsion F_ne = -K_N h of an overlap (eq. 5)
  static DISC_INLINE double normal_elastic(const Constants &c, double h) { return c.kn * (h < 0.0 ? -h : 0.0); }

  // viscous F_nv = -gamma_n vn, gamma_n = zeta gamma_crit (eq. 6); weight: 1 in contact, 0 apart, or a missing_share()
  static DISC_INLINE double normal_damping(const Constants &c, double gamma_crit, double vn, double weight)
  {
    return -c.zeta * gamma_crit * vn * weight;
  }

  // size of the attraction: F0 in contact, F0 (1 - h/D0) in the tail (eqs. 4, 5)
  static DISC_INLINE double attraction_size(const Constants &c, double h)
  {
    return h < 0.0 ? c.f0 : h < c.d0 ? c.f0 - c.slope * h : 0.0;
  }

  // tangential spring F_t = -K_T xi_t, |F_t| <= mu F_ne (eq. 8); xi_t grows by dxi
  template <bool DISSIPATION>
  static DISC_INLINE double tangential(const Constants &c, double fn_elastic, double dxi, double &xi_t,
                                       double &dissipated)
  {
    xi_t = apply_coulomb_limit<DISSIPATION>(xi_t, dxi, c.xi_t_limit * fn_elastic, c.kt, dissipated);
    return -c.kt * xi_t;
  }

  // rolling spring M_r = -K_r xi_r, |M_r| <= mu_r F_ne (eq. 10)
  template <bool DISSIPATION>
  static DISC_INLINE double rolling(const Constants &c, double fn_elastic, double dxi, double &xi_r, double &dissipated)
  {
    xi_r = apply_coulomb_limit<DISSIPATION>(xi_r, dxi, c.xi_r_limit * fn_elastic, c.kr, dissipated);
    return -c.kr * xi_r;
  }

  // force of the dashpot beside a spring.  dxi_elastic: growth of xi after the limit, which sets the force; dxi: the
  // whole displacement, over which it does work
  template <bool DISSIPATION>
  static DISC_INLINE double dashpot(double gamma, double gamma_crit, double dxi_elastic, double in_contact, double dxi,
                                    double &last_force, double &dissipated)
  {
    const double force = -gamma * gamma_crit * dxi_elastic * in_contact;
    if (DISSIPATION) dissipated -= 0.5 * (last_force + force) * dxi;
    last_force = force;
    return force;
  }

  // ---- a block of pairs ----

  struct Geometry {
    double nx, ny, h, in_contact;    // normal; gap; 1 if h < 0, else 0
    double un, ut;                   // mean relative velocity of the centres over the step
    double n_rotation;               // angle by which n turns in half a step
    double vn_mid;                   // d|b|/dt in the middle of the step; without SECOND along n at its end
  };

  static DISC_INLINE Geometry geometry(const Constants &c, const Block &b, int k)
  {
    const double distance = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]), inverse = 1.0 / distance;
    const double nx = b.bx[k] * inverse, ny = b.by[k] * inverse, h = distance - b.radsum[k];
    const double un = nx * b.ux[k] + ny * b.uy[k], ut = nx * b.uy[k] - ny * b.ux[k];
    const double n_rotation = 0.5 * c.dt * inverse * ut;
    return {nx, ny, h, h < 0.0 ? 1.0 : 0.0, un, ut, n_rotation, SECOND ? un - n_rotation * ut : un};
  }

  /* The Coulomb and rolling limits hold for the elastic repulsion alone (eqs. 8, 10): neither the viscous part nor F0
     enters.  An open contact has a limit of zero, which empties its springs. */
  template <bool DISSIPATION>
  DISC_INLINE void compute_forces(const StepKinematics &step, Block &__restrict b, int count) const
  {
    const Constants c = constants(step);
    const double dt = c.dt;
    const double *const __restrict gamma_crit = b.pair_constant;
    double *const __restrict xi_t = b.history[H::XI_T], *const __restrict xi_r = b.history[H::XI_R];
    double *const __restrict vn = b.history[H::VN], *const __restrict fn_damp = b.history[H::FN_DAMP];
    double *const __restrict ft_damp = b.history[H::FT_DAMP], *const __restrict mr_damp = b.history[H::MR_DAMP];
    for (int k = 0; k < count; k++) {
      const auto [nx, ny, h, in_contact, un, ut, n_rotation, vn_mid] = geometry(c, b, k);
      // the gap at the beginning of the step, h - dt vn_mid, had the other sign
      if (ONSET) b.contact_changed[k] = h * (h - dt * vn_mid) < 0.0 ? 1.0 : 0.0;

      const double fn_elastic = normal_elastic(c, h);
      double normal = fn_elastic, ft = 0.0;
      if (DAMPING) {
        const double vn_end = SECOND ? vn_mid + c.extrapolation * (vn_mid - vn[k]) : un;
        if (SECOND) {
          vn[k] = vn_mid;
          b.vn_end[k] = vn_end;
        }
        const double damping = normal_damping(c, gamma_crit[k], vn_end, in_contact);
        if (DISSIPATION) b.dissipated_viscous[k] = -0.5 * (fn_damp[k] + damping) * vn_mid * dt;
        fn_damp[k] = damping;
        normal += damping;
      }
      if (COHESION) normal -= attraction_size(c, h);
      if (FRICTION) {
        const double dxi = ((SECOND ? ut + n_rotation * un : ut) - b.vt_rot[k]) * dt, before = xi_t[k];
        double xi = before;
        ft = tangential<DISSIPATION>(c, fn_elastic, dxi, xi, b.dissipated_sliding[k]);
        if (DASHPOTS)
          ft += dashpot<DISSIPATION>(c.gamma_t, gamma_crit[k], xi - before, in_contact, dxi, ft_damp[k],
                                     b.dissipated_viscous[k]);
        xi_t[k] = xi;
        b.tangential[k] = ft;
      }
      if (ROLLING) {
        const double dxi = b.omega_rel[k] * dt, before = xi_r[k];
        double xi = before;
        double mr = rolling<DISSIPATION>(c, fn_elastic, dxi, xi, b.dissipated_rolling[k]);
        if (DASHPOTS)
          mr += dashpot<DISSIPATION>(c.gamma_r * b.radsum[k], gamma_crit[k], xi - before, in_contact, dxi, mr_damp[k],
                                     b.dissipated_viscous[k]);
        xi_r[k] = xi;
        b.moment[k] = mr;
      }
      b.overlap[k] = -h > b.overlap[k] ? -h : b.overlap[k];
      const double approach = h < c.range ? -vn_mid : 0.0;
      b.approach[k] = approach > b.approach[k] ? approach : b.approach[k];
      b.fx[k] = normal * nx - ft * ny;
      b.fy[k] = normal * ny + ft * nx;
    }
    if (ONSET && any(b.contact_changed, count))
      for (int k = 0; k < count; k++)
        if (b.contact_changed[k] != 0.0) correct_contact_onset<DISSIPATION>(c, b, k);
  }

  /* Pair k closed or opened in the step that ends here: its damper acted for the fraction q of it.  If it closed, its
     springs grew for q; if it opened, the main loop has emptied them.  Dashpots of a contact that closed act from the
     next step on. */
  template <bool DISSIPATION>
  DISC_INLINE void correct_contact_onset(const Constants &c, Block &__restrict b, int k) const
  {
    // not geometry(): that multiplies by 1/distance and rounds otherwise
    const double distance = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
    const double nx = b.bx[k] / distance, ny = b.by[k] / distance, h = distance - b.radsum[k];
    const double un = nx * b.ux[k] + ny * b.uy[k], ut = nx * b.uy[k] - ny * b.ux[k];
    const double n_rotation = 0.5 * c.dt * ut / distance, vn_mid = un - n_rotation * ut, h_before = h - c.dt * vn_mid;
    const bool closed = h < 0.0;
    // the overlap at the end (closed) or beginning (opened) of the step over the change of the gap
    const double q = (closed ? h : h_before) / -std::fabs(h - h_before);
    const double fn_elastic = -c.kn * h;    // of a closed contact; not used where it opened
    double added_normal = 0.0, added_tangential = 0.0;
    if (DAMPING) {
      added_normal = normal_damping(c, b.pair_constant[k], b.vn_end[k], missing_share(q));
      b.history[H::FN_DAMP][k] += added_normal;
      if (DISSIPATION) b.dissipated_viscous[k] -= 0.5 * added_normal * vn_mid * c.dt;
    }
    if (FRICTION && closed) {
      const double dxi = c.dt * (ut + n_rotation * un - b.vt_rot[k]);
      double &xi_t = b.history[H::XI_T][k] = 0.0;
      added_tangential =
          tangential<DISSIPATION>(c, fn_elastic, q * dxi, xi_t, b.dissipated_sliding[k]) - b.tangential[k];
      b.tangential[k] += added_tangential;
      if (DASHPOTS) drop_dashpot<DISSIPATION>(b, b.history[H::FT_DAMP][k], dxi, k);
    }
    if (ROLLING && closed) {
      const double dxi = c.dt * b.omega_rel[k];
      double &xi_r = b.history[H::XI_R][k] = 0.0;
      b.moment[k] = rolling<DISSIPATION>(c, fn_elastic, q * dxi, xi_r, b.dissipated_rolling[k]);
      if (DASHPOTS) drop_dashpot<DISSIPATION>(b, b.history[H::MR_DAMP][k], dxi, k);
    }
    b.fx[k] += added_normal * nx - added_tangential * ny;
    b.fy[k] += added_normal * ny + added_tangential * nx;
  }

  template <bool DISSIPATION> static DISC_INLINE void drop_dashpot(Block &b, double &damping, double dxi, int k)
  {
    if (DISSIPATION) b.dissipated_viscous[k] += 0.5 * damping * dxi;
    damping = 0.0;
  }
};

}    // namespace disc

#endif
