/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_RUN_DISC_H
#define LMP_RUN_DISC_H

#include "engine_verlet.h"

namespace LAMMPS_NS
{

/* run_style verlet/disc

   LAMMPS's velocity Verlet; steps that nothing looks at (no output, no fix at the end of the step) run on the kernel's
   arrays alone, without the copies, the communication and the calls that only others need.  Same bits as run_style
   verlet.  With fixes of other styles that act within the step, every step is one of LAMMPS's own. */
class RunDisc : public Verlet
{
public:
  RunDisc(class LAMMPS *, int, char **);
  void run(int) override;

private:
  bool find_styles();
  bigint next_observed_step(bigint last) const;
  void run_unobserved(bigint last);
  void rebuild();

  class PairDisc *pair = nullptr;
  class FixDiscHistory *history = nullptr;
  class FixDiscIntegrate *integrate = nullptr;
  class FixDiscFeed *feed = nullptr;
};

}    // namespace LAMMPS_NS

#endif
