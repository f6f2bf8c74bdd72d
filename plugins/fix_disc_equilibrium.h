/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_EQUILIBRIUM_H
#define LMP_FIX_DISC_EQUILIBRIUM_H

#include "contact_pairs.h"
#include "fix.h"

#include <cstdint>
#include <string>
#include <vector>

namespace LAMMPS_NS
{

// clang-format off
/* fix ID all disc/equilibrium N unit F1 [length a] [stress S_x S_y] [hold t] [force e_f] [energy e_k] [share e_s]
                               [stop FILE] [aggregates yes|no]

   Every N steps, how far the packing is from equilibrium by G07 sec. II D, in units of the force F1 = max(F0, P a):

     largest net force < e_f F1, largest net moment < e_f F1 a
     kinetic energy per grain < e_k F1 a, beyond the mean drift; of all grains where the law attracts, else of the
       supported ones, since no force stops the others
     on each controlled axis |stress - S| < min(e_f F1/a, e_s |S|), the second bound not for S = 0; the contacts must
       bear it: the part from pair forces alone keeps that bound too, so that neither an empty cell nor a gas is in
       equilibrium

   Defaults: length 1, force 1e-4, energy 5e-8, share 0.01, hold 0.

   The pair style is one of this plugin, or one of LAMMPS's granular ones, see ContactPairs.

   Scalar: 1 once every criterion has held at every check for a time `hold`, else 0 (a variable of it ends a run through
   fix halt).

   Vector:
     1       largest net force
     2       largest net moment
     3, 4    stresses
     5       kinetic energy per grain as the criterion has it
     6       kinetic energy per grain, of all grains and with drift
     7       unsupported grains, the column `rattlers` of a series
     8, 9    contacts, distant pairs
     10      time the criteria have held
     11, 12  largest overlap, fastest approach of two grains that interact, at this check
     13      time since the network last changed: the contacts of supported grains, and the number of aggregates, if
             counted
     14      1 once the stop file exists
     15, 16  number of aggregates, grains in the largest (0 unless asked for with `aggregates yes`): sets of grains
             connected by contacts or distant pairs, through the periodic cell; a lone grain is one
     17      largest error of the stress over its tolerance, of both axes, of the whole and of its part from pair
             forces (0 without a controlled axis)
     18-20   over all steps so far, not only those checked: largest overlap, fastest approach of two grains that
             interact, longest way of such an approach in one step; 0 for pair styles of LAMMPS, which do not tell */
// clang-format on
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
  // clang-format off
  enum Quantity {    // the vector, in its order
    FORCE, MOMENT,
    STRESS_X, STRESS_Y,
    KINETIC, KINETIC_RAW,
    UNSUPPORTED,
    CONTACTS, DISTANT,
    HELD,
    OVERLAP, APPROACH,
    SINCE_CHANGE,
    STOP,
    AGGREGATES, LARGEST_AGGREGATE,
    STRESS_ERROR,
    LARGEST_OVERLAP, LARGEST_APPROACH, LARGEST_ADVANCE,
    QUANTITIES
  };
  // clang-format on

  class Keywords keywords();
  void set_stress(char **value);
  void check() const;
  void measure();
  void measure_pairs(double *stress);
  void measure_grains(const double *stress);
  void monitor_network();
  void count_aggregates();
  void label_aggregates();
  double stress_error(const double *pair_stress) const;
  bool within_tolerance() const;
  bool supports_grain(const PairDisc::Interaction &) const;
  double needed_supports() const;
  double now() const;

  ContactPairs pairs;
  double unit = 0.0, length = 1.0, force_tolerance = 1.0e-4, energy_tolerance = 5.0e-8, hold = 0.0, share = 0.01;
  bool controlled[2] = {false, false};
  double target[2] = {0.0, 0.0};
  double quantity[QUANTITIES] = {};
  double held_since = -1.0;        // time since when all criteria hold, < 0 if they do not
  double network_changed = 0.0;    // time at which the network was last seen to change
  uint64_t network = 0;            // sum over its contacts of a hash of the two tags
  std::string stop_file;
  std::vector<double> supports;    // per grain: interactions that carry more than the tolerance
  bool aggregates = false;
  double aggregate_count = -1.0;    // aggregates counted last; a change of their number is a change of the network
  std::vector<double> label;        // per grain: smallest tag known to belong to its aggregate
  bool labelling = false;           // communication carries labels (smallest wins), not `supports` (summed)
};

}    // namespace LAMMPS_NS

#endif
