/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_COHESIVE_H
#define LMP_PAIR_DISC_COHESIVE_H

#include "kernels/cohesive.h"
#include "pair_disc.h"

namespace LAMMPS_NS
{

// clang-format off
/* pair_style disc/cohesive [account yes|no] [scheme extrapolated|half_step]
   pair_coeff * * kn K_N [kt K_T] [zeta z] [mu m] [f0 F0] [d0 D0] [kr K_r] [mur mu_r] [zetat z_t] [zetar z_r]

   The exact law of G07 (kernels/cohesive.h).  A term whose coefficient is zero or absent costs nothing. */
// clang-format on
class PairDiscCohesive : public PairDisc
{
public:
  explicit PairDiscCohesive(class LAMMPS *lmp) : PairDisc(lmp) {}
  void coeff(int, char **) override;
  void init_style() override;
  void write_restart(FILE *fp) override { write_law(fp, &law, sizeof(law)); }
  void read_restart(FILE *fp) override { read_law(fp, &law, sizeof(law)); }
  void *extract(const char *, int &) override;

  double cutoff_gap() const override { return law.cutoff_gap(); }
  double pair_constant(int i, int j) const override;
  disc::HistoryColumns history_columns() const override { return disc::columns_of<disc::CohesiveHistory>(); }
  Interaction interaction(int c) const override;
  Energy energy(const Interaction &) const override;

private:
  disc::PairSums compute_active_pairs(bool stress) override;
  std::vector<Coefficient> coefficients();
  void check();

  disc::CohesiveLaw law;
};

}    // namespace LAMMPS_NS

#endif
