/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_COHESIVE_H
#define LMP_PAIR_DISC_COHESIVE_H

#include "kernels/cohesive.h"
#include "pair_disc.h"

namespace LAMMPS_NS
{

/* pair_style disc/cohesive [account yes|no] [scheme second|paper]
   pair_coeff * * kn K_N kt K_T zeta z mu m f0 F0 d0 D0 kr K_r mur mu_r zetat z_t zetar z_r

   The exact law of G07 (kernels/cohesive.h).  kn is required; a term whose coefficient is zero or absent costs nothing.
 */
class PairDiscCohesive : public PairDisc
{
public:
  explicit PairDiscCohesive(class LAMMPS *lmp) : PairDisc(lmp) {}
  void coeff(int, char **) override;
  void init_style() override;
  void write_restart(FILE *fp) override { write_law(fp, &law, sizeof(law)); }
  void read_restart(FILE *fp) override { read_law(fp, &law, sizeof(law)); }
  void *extract(const char *, int &) override;

  double range() const override { return law.range(); }
  double viscosity(int i, int j) const override;
  Interaction interaction(int c) const override;
  Energy energy(const Interaction &) const override;

private:
  static constexpr int FLAGS = 7;
  using Kernel = disc::Sums (PairDiscCohesive::*)(bool);
  template <bool SECOND, bool DAMPING, bool COHESION, bool FRICTION, bool ROLLING, bool ACCOUNT, bool DASHPOTS>
  disc::Sums kernel(bool stress);
  template <bool... CHOSEN> Kernel choose(const bool *flags) const;
  disc::Sums sweep(bool stress) override;
  std::vector<Coefficient> coefficients();
  void check();

  disc::CohesiveLaw law;
};

}    // namespace LAMMPS_NS

#endif
