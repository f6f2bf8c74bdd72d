/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_RESUME_H
#define LMP_FIX_DISC_RESUME_H

#include "fix.h"
#include "kernels/pair_loop.h"

#include <vector>

namespace LAMMPS_NS
{

/* fix ID all disc/resume

   Makes a run go on from a restart file as the run that wrote it, under a pair style that is not of this plugin. LAMMPS
   evaluates forces anew there, with velocities of the full step, while those of a run saw velocities of the half step.
   Restart files that are written within a run keep forces, torques and virial; they are put back before the fixes that
   are defined later look at them: define it before the one that integrates.

     fix_modify ID forces anew      the next run starts as any other, not as the rest of an interrupted one */
class FixDiscResume : public Fix
{
public:
  FixDiscResume(class LAMMPS *, int, char **);
  ~FixDiscResume() override;
  int setmask() override;
  void setup_pre_exchange() override;
  void setup(int) override;
  int modify_param(int, char **) override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override { return 1 + FORCE; }
  int maxsize_restart() override { return 1 + FORCE; }

private:
  static constexpr int FORCE = 3, VIRIAL = 6;    // doubles of a grain, and of a rank
  bool continues() const;

  std::vector<disc::GrainForce> restored;    // per grain, of the restart file
  std::vector<double> virial;                // of this rank
  bigint step = -1, since = 0;               // that step; time counts from the other one
  double time = 0.0;
};

}    // namespace LAMMPS_NS

#endif
