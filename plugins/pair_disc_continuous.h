/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_CONTINUOUS_H
#define LMP_PAIR_DISC_CONTINUOUS_H

#include "kernels/continuous.h"
#include "pair_disc.h"

namespace LAMMPS_NS
{

/* pair_style disc/continuous [account yes|no]
   pair_coeff * * [force F] [index n] [cutoff c] [hooke k] [mu m] [alpha a] [damping z] [printed_rotation 0|1]
                  [printed_damping 0|1]

   The law of B97 (kernels/continuous.h) and, with hooke, its linear twin.  A pair interacts below r0 = c sigma_ij; its
   memory begins there.  The record's `springs.stretch` is d; there is no rolling spring, and `springs.rotation` holds
   the viscous part of T of the last force evaluation, for output. */
class PairDiscContinuous : public PairDisc
{
public:
  explicit PairDiscContinuous(class LAMMPS *lmp) : PairDisc(lmp) {}
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void compute(int, int) override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;

  double range() const override { return (law.reach() - 1.0) * largest; }    // of the largest pair
  double viscosity(int i, int j) const override;
  Interaction interaction(const disc::Neighbours &) const override;
  Energy energy(const Interaction &) const override;

private:
  template <bool SPRING, bool FRICTION, bool ACCOUNT, bool NEWTON> void kernel();
  using Kernel = void (PairDiscContinuous::*)();
  template <bool... CHOSEN> Kernel choose(const bool *flags) const;
  void check() const;
  void allocate();
  double largest_diameter() const;

  disc::ContinuousLaw law;
  bool account = true;     // sum up what is dissipated
  double largest = 0.0;    // diameter at the last init; no grain that comes later may be larger
};

}    // namespace LAMMPS_NS

#endif
