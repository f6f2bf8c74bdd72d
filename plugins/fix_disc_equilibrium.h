/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_EQUILIBRIUM_H
#define LMP_FIX_DISC_EQUILIBRIUM_H

#include "fix.h"
#include "pair_disc.h"

#include <cstdint>
#include <string>
#include <vector>

namespace LAMMPS_NS
{

/* fix ID all disc/equilibrium N unit F1 length a [stress S_x S_y] [hold t] [force e_f] [energy e_k] [share e_s]
   [stop file] [aggregates yes|no]

   Every N steps, how far the packing is from equilibrium by G07 sec. II D, in units of the force F1 = max(F0, P a):
   largest net force < e_f F1, largest net moment < e_f F1 a, kinetic energy per grain < e_k F1 a, and on each
   controlled axis |stress - target| < min(e_f F1/a, e_s |target|), without the second bound at a target of zero.  The
   contacts must bear the stress: its part from pair forces alone keeps that bound too, so that neither an empty cell
   nor a gas is in equilibrium.  The kinetic energy is that beyond the mean drift; of all grains where the law attracts,
   of those that something holds where it does not, since no force stops the others.  Defaults: e_f = 1e-4, e_k = 5e-8,
   e_s = 0.01, hold = 0.

   Scalar: 1 once every criterion has held at every check for a time `hold`, else 0 (a variable of it ends a
   run through fix halt).
   Vector: 1 largest net force; 2 largest net moment; 3, 4 stresses; 5 kinetic energy per grain as the criterion has it;
   6 raw kinetic energy per grain; 7 rattlers; 8 contacts; 9 distant pairs; 10 time the criteria have held;
   11 largest overlap; 12 largest approach speed of two touching or attracting grains; 13 time since the network, the
   contacts that hold grains which are no rattlers (and the number of aggregates, if counted), last changed; 14 is 1
   once the stop file exists; 15 number of aggregates, 16 grains in the largest (0 unless asked for with `aggregates
   yes`): sets of grains connected by interactions, contacts or distant pairs, through the periodic cell; a lone grain
   is one; 17 largest error of the stress over its tolerance, of both axes, of the whole and of its part from pair
   forces (0 without a controlled axis); 18, 19, 20 over all steps so far, not only those looked at: largest overlap,
   fastest approach of two grains that interact, longest way of such an approach in one step. */
class FixDiscEquilibrium : public Fix
{
public:
  FixDiscEquilibrium(class LAMMPS *, int, char **);
  int setmask() override;
  void init() override;
  void setup(int) override;
  void end_of_step() override;
  double compute_scalar() override;
  double compute_vector(int) override;
  int modify_param(int, char **) override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

private:
  enum Figure {
    FORCE,
    MOMENT,
    STRESS_X,
    STRESS_Y,
    KINETIC,
    KINETIC_RAW,
    RATTLERS,
    CONTACTS,
    DISTANT,
    HELD,
    OVERLAP,
    APPROACH,
    QUIET,
    STOP,
    AGGREGATES,
    LARGEST,
    STRESS_ERROR,
    MOST_OVERLAP,
    MOST_APPROACH,
    MOST_ADVANCE,
    FIGURES
  };

  int parse_stress(int, int, char **);
  void measure();
  void measure_pairs(double *stress);
  void measure_grains(const double *stress);
  void watch_network();
  void count_aggregates();
  void label_aggregates();
  double stress_error(const double *borne) const;
  bool within_tolerance() const;
  bool carries(const PairDisc::Interaction &) const;
  double needed() const;
  double now() const;

  PairDisc *pair = nullptr;
  double unit = 0.0, length = 1.0, force_tolerance = 1.0e-4, energy_tolerance = 5.0e-8, hold = 0.0, share = 0.01;
  bool controlled[2] = {false, false};
  double target[2] = {0.0, 0.0};
  double figure[FIGURES] = {};
  double since = -1.0;     // time since when all criteria hold, < 0 if they do not
  double changed = 0.0;    // time at which the network was last seen to change
  uint64_t network = 0;    // sum over its contacts of a hash of the two tags
  std::string stop_file;
  std::vector<double> carrying;    // per grain: interactions that carry more than the tolerance
  bool aggregates = false;
  double parts = -1.0;          // aggregates counted last; a change of their number is a change of the network
  std::vector<double> label;    // per grain: smallest tag known to belong to its aggregate
  bool labelling = false;       // communication carries labels (smallest wins), not `carrying` (summed)
};

}    // namespace LAMMPS_NS

#endif
