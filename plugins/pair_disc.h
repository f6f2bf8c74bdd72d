/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_DISC_H
#define LMP_PAIR_DISC_H

#include "disc_ghosts.h"
#include "fix_disc_history.h"
#include "pair.h"

#include <vector>

namespace LAMMPS_NS
{

/* What the disc laws share: the neighbour list with contact memory, contact output, stress and energy sums, the reading
   of coefficients.  A law derives from it and brings its kernel, its coefficients and its potentials, in this plugin or
   in another one (docs/extending.md), to which this class is therefore visible. */
class __attribute__((visibility("default"))) PairDisc : public Pair
{
public:
  enum State { APART = 0, DISTANT = 1, CONTACT = 2 };

  struct Interaction {    // of one listed pair, as it acted in the last force evaluation
    State state = APART;
    double bx, by, distance, gap;    // branch vector from i to j
    double elastic = 0.0, viscous = 0.0, attraction = 0.0, tangential = 0.0, moment = 0.0;
    double stretch = 0.0, rotation = 0.0;
    bool sliding = false, rolling = false;

    double normal() const { return elastic + viscous + attraction; }
    double fx() const { return (normal() * bx - tangential * by) / distance; }    // force of i on j
    double fy() const { return (normal() * by + tangential * bx) / distance; }
  };

  struct Energy {
    double elastic = 0.0, tangential = 0.0, rolling = 0.0, adhesive = 0.0;
    double sum() const { return elastic + tangential + rolling + adhesive; }
  };

  explicit PairDisc(class LAMMPS *);
  ~PairDisc() override;
  void settings(int, char **) override;    // [account yes|no] [scheme second|paper]
  void init_style() override;
  double init_one(int, int) override { return largest_diameter() + range(); }
  double single(int, int, int, int, double, double, double, double &) override;

  virtual double range() const = 0;                    // gap up to which the law acts
  virtual double viscosity(int i, int j) const = 0;    // eta of the pair of atoms i, j
  virtual Interaction interaction(int c) const = 0;    // of the close pair c
  virtual Energy energy(const Interaction &) const = 0;

  /* visit(i, j, interaction, weight) for every interacting pair; weight 1/2 where newton off lists a pair twice */
  template <class Visit> void each(Visit visit) const
  {
    const disc::Contacts &close = history->close;
    for (int c = 0; c < close.count; c++) {
      const Interaction now = interaction(c);
      if (now.state != APART) visit(close.i[c], close.j[c], now, counted_once(close.j[c]) ? 1.0 : 0.5);
    }
  }

  void choose_close();    // lists what may act in this step, before the evaluation does
  /* Forces of the grains in history->grains, ghosts included, into history->actions. */
  void evaluate();

  /* The grains as LAMMPS holds them now, on every rank and in every ghost. */
  const std::vector<disc::Grain> &refreshed_grains();

  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;
  void compute(int, int) override;

  DiscGhosts ghosts;
  double force_moment[3] = {0.0, 0.0,
                            0.0};    // sum over pairs of F_x r_x, F_y r_y, F_x r_y on this rank (see wants_stress)
  bool wants_stress = false;         // a fix needs force_moment at every step

protected:
  struct Coefficient {
    const char *name;
    double *value;
  };
  /* The arguments of pair_coeff, '* * name value ...', into the values of `known`; others stay as they are. */
  void read_coefficients(int narg, char **arg, const std::vector<Coefficient> &known);
  void write_law(FILE *, const void *law, size_t bytes) const;    // and the settings, to a restart file
  void read_law(FILE *, void *law, size_t bytes);
  double largest_diameter() const;              // of all ranks
  virtual disc::Sums sweep(bool stress) = 0;    // the law's pass over the close pairs
  Interaction geometry(int c) const;
  void evaluate_standing();
  bool counted_once(int j) const;
  void tally_energy();
  void allocate();

  FixDiscHistory *history = nullptr;
  bool account = true;         // sum up what is dissipated
  bool second_order = true;    // scheme second, not paper
};

}    // namespace LAMMPS_NS

#endif
