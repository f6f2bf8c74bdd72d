/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_INTEGRATE_H
#define LMP_FIX_DISC_INTEGRATE_H

#include "disc_state.h"
#include "fix.h"
#include "kernels/time_integration.h"

#include <string>
#include <vector>

namespace LAMMPS_NS
{

// clang-format off
/* fix ID all disc/integrate [stress S_x S_y] [cell lengths|strain] [mass m] [rate r] [wall u] [convention c] [drag g]
                             [quench 0|1] [gravity g_x g_y] [fixed GROUP]

   Velocity Verlet for discs (I = m R^2/2) in a rectangular periodic cell, fixed or under stress control, for any pair
   style of contacts.  A pair style that is not of this plugin sees, while it computes forces, velocities that include the
   affine motion of the cell, so that its damping and its springs know it; `compute pressure` tells its stress.

   stress S_x S_y    imposed stresses, compression positive; NULL leaves an axis fixed.  Without it the cell is fixed
                     and no stress is summed
   cell lengths      W d2L_a/dt2 = L_b (sigma_aa - S_a), W = m sum(m_i): Parrinello and Rahman's equation for the two
                     lengths (a, b the two axes); default
   cell strain       M d2eps/dt2 = S_a - sigma_aa, eps = 1 - L/L^0, M = m sum(m_i)/L with L = sqrt(L_x L_y) at the start
                     of the stage: G07 eq. 3 as printed
   mass m            see `cell`; default 0.6
   rate r            cap on |d eps/dt|, 0 for none (default)
   wall u            cap on |dL/dt|, 0 for none (default)
   convention c      momentum convention: c in m dv/dt = F + c m (dL/dt / L) v, 0 (default) as physics demands of a
                     velocity relative to the affine motion in G07, 1 for L d2s/dt2 = F/m, -1 for the Hamiltonian of
                     Parrinello and Rahman (s = r/L)
   drag g            background damping, a relaxation aid and not part of the law: -g m v, -g I w and -g M d eps/dt;
                     default 0
   quench 0|1        relaxation aid: a wall that moves against the stress that is left to balance is stopped, so that
                     the cell comes to rest within a few of its periods, however soft the packing; default 0
   gravity g_x g_y   acceleration of every grain (default 0 0); weights are part of the forces on the atoms
   fixed GROUP       grains of this group stay where they are, whatever acts on them; their forces read 0

   fix_modify ID stress S_x S_y   starts a new stage: new targets, strain measured from the present cell
   fix_modify ID drag g           switches the background damping on or off; quench likewise

   Vector: 1, 2 stresses; 3, 4 strain rates d eps/dt; 5 work done on the grains by the cell; 6 W or M; 7 energy taken by
   the background damping; 8 potential energy of the weights, - sum of m g.x over the grains that move. */
// clang-format on
class FixDiscIntegrate : public Fix
{
public:
  FixDiscIntegrate(class LAMMPS *, int, char **);
  ~FixDiscIntegrate() override;
  int setmask() override;
  void init() override;
  void setup_post_neighbor() override { post_neighbor(); }
  void post_neighbor() override;
  void setup(int) override;
  void setup_pre_force(int) override { pre_force(0); }
  void pre_force(int) override;
  void post_force(int) override;
  void initial_integrate(int) override;
  void final_integrate() override;
  double compute_vector(int) override;
  int modify_param(int, char **) override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  /* On the kernel's grains and forces, for a step that LAMMPS does not look at: end the last step, begin the next. */
  void integrate(bool final, bool initial);

private:
  struct Axis {
    bool controlled = false;
    double target = 0.0;         // imposed stress
    double length0 = 0.0;        // length at the start of the stage, L^0
    double strain_rate = 0.0;    // d eps/dt = -dL/dt / L^0, at the half step while positions move
    double stress = 0.0;         // measured stress
    double virial = 0.0;         // sum over pairs of F r
    double mv2 = 0.0;            // sum of m v^2
  };

  class Keywords keywords();
  void set_stress(char **value);
  void set_cell(const std::string &value);
  void set_gravity(char **value);
  void set_fixed(const std::string &value);
  bool moves(int i) const;
  void check() const;
  void begin_stage();
  template <bool FINAL, bool INITIAL, bool DRIFT> void pass();
  void measure_stress(const double *mv2);
  void final_integrate_cell();
  void kick_cell(double dt);
  void read_virial();
  bool scale_cell(disc::Drift &);

  Axis axis[2];
  std::vector<disc::Inertia> inertia_of;    // per grain
  bool stress_control = false;
  double gravity[2] = {0.0, 0.0};
  int fixed = 0;                                                              // group bit
  bool of_lengths = true;                                                     // `cell lengths`, not `cell strain`
  double mass_factor = 0.6, inertia = 0.0, rate_cap = 0.0, wall_cap = 0.0;    // of the cell
  double convention = 0.0;                                                    // momentum convention
  double drag = 0.0, quench = 0.0;    // background damping; cell stopped where it swings back
  double work = 0.0, drag_dissipated = 0.0;
  class PairDisc *pair = nullptr;             // of this plugin; without it
  class FixDiscHistory *history = nullptr;    // its own state of the grains,
  class Compute *pressure = nullptr;          // and the stress of whatever pair style there is
  DiscState own_state;
  DiscState *state = nullptr;            // of the one or the other
  double affine_rate[2] = {0.0, 0.0};    // d ln L/dt in the step that ends with the next forces
  std::vector<double> velocity;          // x and y of all grains and ghosts, while a pair style sees others
};

}    // namespace LAMMPS_NS

#endif
