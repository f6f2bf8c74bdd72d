/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_CONTINUOUS_H
#define LMP_PAIR_DISC_CONTINUOUS_H

#include "kernels/continuous.h"
#include "pair_disc.h"

namespace LAMMPS_NS
{

// clang-format off
/* pair_style disc/continuous [account yes|no] [scheme extrapolated|half_step]
   pair_coeff * * [force F] [index n] [cutoff c] [hooke k] [mu m] [alpha a] [damping z] [printed_rotation 0|1]
                  [printed_damping 0|1]

   The law of B97 (kernels/continuous.h) and, with hooke, its linear twin.  A pair interacts below r0 = c sigma_ij; its
   history begins there. */
// clang-format on
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

  double cutoff_gap() const override { return (law.cutoff_ratio() - 1.0) * largest; }    // of the largest pair
  double pair_constant(int i, int j) const override;
  disc::HistoryColumns history_columns() const override { return disc::columns_of<disc::ContinuousHistory>(); }
  Interaction interaction(int c) const override;
  Energy energy(const Interaction &) const override;

private:
  disc::PairSums compute_active_pairs(bool stress) override;
  void check() const;

  disc::ContinuousLaw law;
  double largest = 0.0;    // diameter at the last init; no grain that comes later may be larger
};

}    // namespace LAMMPS_NS

#endif
