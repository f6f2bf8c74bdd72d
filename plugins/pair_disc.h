/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_H
#define LMP_PAIR_DISC_H

#include "atom.h"
#include "disc_ghosts.h"
#include "fix_disc_history.h"
#include "force.h"
#include "pair.h"

#include <array>
#include <string>
#include <type_traits>
#include <vector>

namespace LAMMPS_NS
{

/* What the disc laws share: the active pair list with contact history, contact output, stress and energy sums, the
   reading of coefficients.  A law derives from it and brings its kernel, its coefficients and its potentials, in this
   plugin or in another one (docs/extending.md), to which this class is therefore visible.

   pair_style STYLE [account yes|no] [scheme extrapolated|half_step] */
class __attribute__((visibility("default"))) PairDisc : public Pair
{
public:
  enum State { APART = 0, DISTANT = 1, CONTACT = 2 };

  struct Interaction {    // of one listed pair, as it acted in the last force evaluation
    State state = APART;
    double bx, by, distance, gap;    // branch vector from i to j
    double elastic = 0.0, viscous = 0.0, attraction = 0.0, tangential = 0.0, moment = 0.0;
    double xi_t = 0.0, xi_r = 0.0;
    bool sliding = false, rolling = false;

    double normal() const { return elastic + viscous + attraction; }
    double fx() const { return (normal() * bx - tangential * by) / distance; }    // force of i on j
    double fy() const { return (normal() * by + tangential * bx) / distance; }
  };

  /* The columns p1, p2, ... of compute pair/local, the contact table: this list is their only statement. */
  // clang-format off
  enum Column {
    ID_I, ID_J,          // tags of the grains
    STATE,               // 0 apart, 1 distant, 2 contact
    BX, BY, GAP,         // branch vector from i to j; |b| - R_i - R_j
    ELASTIC, VISCOUS, ATTRACTION,    // parts of the normal force
    TANGENTIAL, MOMENT,  // tangential force, rolling moment of i on j, dashpots included
    DU, DTHETA,          // elastic displacements xi_t, xi_r
    SLIDING, ROLLING,    // 1 if the spring is at its limit
    COLUMNS
  };
  /* The vector of compute pair: potential energies, dissipated energies. */
  enum Sum { E_ELASTIC, E_TANGENTIAL, E_ROLLING, E_ADHESIVE, D_VISCOUS, D_SLIDING, D_ROLLING, SUMS };
  // clang-format on

  struct Energy {
    double elastic = 0.0, tangential = 0.0, rolling = 0.0, adhesive = 0.0;
    double sum() const { return elastic + tangential + rolling + adhesive; }
  };

  explicit PairDisc(class LAMMPS *);
  ~PairDisc() override;
  void settings(int, char **) override;
  void init_style() override;
  double init_one(int, int) override { return largest_diameter() + cutoff_gap(); }
  double single(int, int, int, int, double, double, double, double &) override;

  virtual double cutoff_gap() const = 0;                   // gap up to which the law acts
  virtual double pair_constant(int i, int j) const = 0;    // what the kernel needs of the atoms i, j beside their radii
  virtual disc::HistoryColumns history_columns() const = 0;
  virtual Interaction interaction(int c) const = 0;    // of the active pair c
  virtual Energy energy(const Interaction &) const = 0;

  /* visit(i, j, interaction, weight) for every interacting pair; weight 1/2 where newton off lists a pair twice */
  template <class Visit> void for_each_pair(Visit visit) const
  {
    const disc::ActivePairs &active = history->pairs.active;
    for (int c = 0; c < active.count; c++) {
      const Interaction now = interaction(c);
      if (now.state != APART) visit(active.i[c], active.j[c], now, counted_once(active.j[c]) ? 1.0 : 0.5);
    }
  }

  void rebuild_pair_list();    // lists what may act in this step, before the evaluation does
  /* Forces of the grains in history->state, ghosts included. */
  void evaluate();

  /* The grains as LAMMPS holds them now, on every rank and in every ghost. */
  const std::vector<disc::Grain> &refreshed_grains();

  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  void compute(int, int) override;

  DiscGhosts ghosts;
  double pair_virial[3] = {0.0, 0.0, 0.0};    // sum over pairs of F_x b_x, F_y b_y, F_x b_y on this rank
  bool needs_virial = false;                  // a fix needs pair_virial at every step

protected:
  struct Coefficient {
    const char *name;
    double *value;
  };
  /* The arguments of pair_coeff, '* * name value ...', into the values of `known`; others stay as they are. */
  void read_coefficients(int narg, char **arg, const std::vector<Coefficient> &known);
  void write_law(FILE *, const void *law, size_t bytes) const;    // and the settings, to a restart file
  void read_law(FILE *, void *law, size_t bytes);
  double largest_diameter() const;    // of all ranks

  virtual disc::PairSums compute_active_pairs(bool stress) = 0;    // the law's pair loop
  /* That loop, with the kernel of the law. */
  template <class Kernel, bool DISSIPATION> disc::PairSums pair_loop(const Kernel &kernel, bool stress)
  {
    DiscState &state = history->state;
    return disc::pair_loop<Kernel, DISSIPATION>(kernel, state.kinematics, state.grains.data(), atom->nlocal,
                                                force->newton_pair, stress, history->pairs.active, state.forces.data());
  }
  double history_value(int column, int c) const { return history->pairs.active.history[column][c]; }

  void set_scheme(const std::string &value);
  Interaction geometry(int c) const;
  void evaluate_setup();
  bool counted_once(int j) const;
  void tally_energy();
  void allocate();

  FixDiscHistory *history = nullptr;
  bool account = true;         // sum the dissipated energy
  bool second_order = true;    // scheme extrapolated, not half_step
};

/* Call with one std::bool_constant per flag: turns run-time flags into template arguments. */
template <size_t N, class Call, class... Chosen>
auto call_with_flags(const std::array<bool, N> &flags, const Call &call, Chosen... chosen)
{
  if constexpr (sizeof...(Chosen) == N)
    return call(chosen...);
  else
    return flags[sizeof...(Chosen)] ? call_with_flags(flags, call, chosen..., std::true_type{})
                                    : call_with_flags(flags, call, chosen..., std::false_type{});
}

}    // namespace LAMMPS_NS

#endif
