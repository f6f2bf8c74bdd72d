/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_STIFFEN_H
#define LMP_FIX_DISC_STIFFEN_H

#include "fix.h"

namespace LAMMPS_NS
{

/* fix ID all disc/stiffen N factor time

   Stiffness ramp: multiplies K_N, K_T and K_r by `factor` in the given time, geometrically and every N steps, starting
   at the step at which the fix first runs (series B of G07, sec. III B 2).

   Tangential forces and rolling moments do not jump: when K_T and K_r grow, the elastic displacements shrink by the
   same ratio.  The normal elastic force grows by the ratio of one update and the overlap gives way: the ramp must be
   slow against the vibrations of the packing.  The damping coefficient gamma_n follows its law, proportional to
   sqrt(K_N).

   Scalar: 1 once the end is reached.  Vector: 1 factor reached; 2 work that the change of stiffness did on the springs
   (what they store more, or less, at the instant of each update). */
class FixDiscStiffen : public Fix
{
public:
  FixDiscStiffen(class LAMMPS *, int, char **);
  int setmask() override;
  void init() override;
  void pre_force(int) override;
  double compute_scalar() override;
  double compute_vector(int) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

private:
  double factor_at(bigint step) const;
  void set_factor(double value);
  double stored_energy() const;

  static constexpr int STIFFNESSES = 3;
  class PairDisc *pair = nullptr;
  class FixDiscHistory *history = nullptr;
  double *stiffness[STIFFNESSES] = {};    // K_N, K_T, K_r of the law
  double initial[STIFFNESSES] = {};       // before the ramp
  double factor = 1.0, duration = 0.0;    // of the whole ramp
  double reached = 1.0, work = 0.0;       // factor now; work, of this rank
  bigint ramp_start = -1;                 // first step of the ramp
};

}    // namespace LAMMPS_NS

#endif
