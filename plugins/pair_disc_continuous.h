/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_CONTINUOUS_H
#define LMP_PAIR_DISC_CONTINUOUS_H

#include "kernels/continuous.h"
#include "pair_disc.h"

namespace LAMMPS_NS
{

/* pair_style disc/continuous [account yes|no] [scheme second|paper]
   pair_coeff * * [force F] [index n] [cutoff c] [hooke k] [mu m] [alpha a] [damping z] [printed_rotation 0|1]
                  [printed_damping 0|1]

   The law of B97 (kernels/continuous.h) and, with hooke, its linear twin.  A pair interacts below r0 = c sigma_ij; its
   memory begins there. */
class PairDiscContinuous : public PairDisc
{
public:
  explicit PairDiscContinuous(class LAMMPS *lmp) : PairDisc(lmp) {}
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void compute(int, int) override;
  void write_restart(FILE *fp) override { write_law(fp, &law, sizeof(law)); }
  void read_restart(FILE *fp) override { read_law(fp, &law, sizeof(law)); }

  double range() const override { return (law.reach() - 1.0) * largest; }    // of the largest pair
  double viscosity(int i, int j) const override;
  Interaction interaction(int c) const override;
  Energy energy(const Interaction &) const override;

private:
  static constexpr int FLAGS = 4;
  using Kernel = disc::Sums (PairDiscContinuous::*)(bool);
  template <bool SECOND, bool SPRING, bool FRICTION, bool ACCOUNT> disc::Sums kernel(bool stress);
  template <bool... CHOSEN> Kernel choose(const bool *flags) const;
  disc::Sums sweep(bool stress) override;
  void check() const;

  disc::ContinuousLaw law;
  double largest = 0.0;    // diameter at the last init; no grain that comes later may be larger
};

}    // namespace LAMMPS_NS

#endif
