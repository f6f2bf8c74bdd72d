/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_TAIL_H
#define LMP_PAIR_DISC_TAIL_H

#include "pair.h"

namespace LAMMPS_NS
{

/* pair_style disc/tail
   pair_coeff * * f0 F0 d0 D0

   The attraction of G07 (eqs. 4, 5) alone, for use beside a contact style of LAMMPS in hybrid/overlay: -F0 in contact,
   -F0 (1 - h/D0) for gaps 0 <= h <= D0.  No history, no dissipation. */
class PairDiscTail : public Pair
{
public:
  explicit PairDiscTail(class LAMMPS *);
  ~PairDiscTail() override;
  void compute(int, int) override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  double single(int, int, int, int, double, double, double, double &) override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;

  double range() const { return f0 > 0.0 ? d0 : 0.0; }    // gap up to which it acts

private:
  void allocate();
  double attraction(double gap) const;    // size of the attraction, 0 beyond its range
  double energy(double gap) const;        // its potential, 0 at h = D0

  double f0 = 0.0, d0 = 0.0;
};

}    // namespace LAMMPS_NS

#endif
