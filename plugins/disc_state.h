/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_DISC_STATE_H
#define LMP_DISC_STATE_H

#include "kernels/pair_loop.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS
{

/* The kernel's copies of what LAMMPS holds of the grains, the step they make, and the sums over the steps so far. */
class DiscState : protected Pointers
{
public:
  explicit DiscState(class LAMMPS *lmp) : Pointers(lmp) {}

  // LAMMPS's arrays -> grains, forces; and back
  void load(int first, int last);
  void load_forces();
  void store() const;
  void store_forces() const;

  void resize();          // to the grains and ghosts of this rank, with forces reset
  void reset_forces();    // to the weights of the grains of this rank
  /* The step that ends here scales the cell and moves grains in it. */
  void set_kinematics(const double *cell_scaling, bool second_order);
  void stop_kinematics();                    // no time passes until the next evaluation
  void add_sums(const disc::PairSums &);     // of one evaluation
  disc::Extremes global_extremes() const;    // of all ranks; collective
  double memory_usage() const;

  std::vector<disc::Grain> grains;         // owned and ghosts
  std::vector<disc::GrainForce> forces;    // zero between steps for ghosts
  disc::StepKinematics kinematics;         // since the last evaluation
  disc::PairSums dissipated;               // energies of all steps so far, of this rank
  disc::Extremes extremes;                 // of any step so far, of this rank
  double gravity[2] = {0.0, 0.0};          // set by fix disc/integrate, like the next
  int fixed = 0;                           // group bit of grains that do not move and have no weight
};

}    // namespace LAMMPS_NS

#endif
