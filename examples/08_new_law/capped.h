/* The law itself, for one block of pairs: a spring whose force does not grow beyond a cap, as a soft coating would
   give. Stateless; signs and the names of the block's arrays as in plugins/kernels/pair_loop.h. */

#ifndef CAPPED_H
#define CAPPED_H

#include "kernels/pair_loop.h"

struct CappedLaw {
  double kn = 0.0;     // stiffness K_N [force/length]
  double cap = 0.0;    // largest force [force]

  // normal force min(-K_N h, cap) in contact
  DISC_INLINE double normal_elastic(double h) const
  {
    const double spring = h < 0.0 ? -kn * h : 0.0;
    return spring < cap ? spring : cap;
  }
  double energy(double h) const    // its potential
  {
    const double elastic = normal_elastic(h) / kn;
    return h < 0.0 ? 0.5 * kn * elastic * elastic + cap * (-h - elastic) : 0.0;
  }
};

/* Without memory: the contact history has no columns. */
struct CappedHistory {
  static constexpr int COUNT = 0;
  static constexpr const disc::HistoryColumn *columns = nullptr;
};

struct Capped {
  // what the law uses of a pair; the rest is not gathered, computed or scattered
  static constexpr bool DAMPING = false, FRICTION = false, ROLLING = false;
  CappedLaw law;

  template <bool DISSIPATION>
  DISC_INLINE void compute_forces(const disc::StepKinematics &, disc::Block &__restrict b, int count) const
  {
    for (int k = 0; k < count; k++) {
      const double distance = std::sqrt(b.bx[k] * b.bx[k] + b.by[k] * b.by[k]);
      const double normal = law.normal_elastic(distance - b.radsum[k]) / distance;
      b.fx[k] = normal * b.bx[k];
      b.fy[k] = normal * b.by[k];
    }
  }
};

#endif
