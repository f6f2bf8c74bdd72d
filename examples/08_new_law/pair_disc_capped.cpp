/* SPDX-License-Identifier: GPL-2.0-or-later
   pair_style disc/capped
   pair_coeff * * kn K_N cap F

   The law of capped.h as a LAMMPS style in a plugin of its own.  PairDisc brings neighbour lists, contact history,
   stress, energy, contact output and restart; it lives in discplugin.so, which LAMMPS loads at start. */

#include "capped.h"
#include "lammps_plugin.h"
#include "pair_disc.h"

#include "error.h"

using namespace LAMMPS_NS;

namespace
{

class PairDiscCapped : public PairDisc
{
public:
  explicit PairDiscCapped(class LAMMPS *lmp) : PairDisc(lmp) {}

  void coeff(int narg, char **arg) override
  {
    law = CappedLaw();
    read_coefficients(narg, arg, {{"kn", &law.kn}, {"cap", &law.cap}});
    if (!(law.kn > 0.0) || !(law.cap > 0.0))
      error->all(FLERR, "pair_coeff of disc/capped: kn = {} and cap = {} must be given and positive", law.kn, law.cap);
  }

  double cutoff_gap() const override { return 0.0; }               // it acts on contacts only
  double pair_constant(int, int) const override { return 0.0; }    // without damping
  disc::HistoryColumns history_columns() const override { return disc::columns_of<CappedHistory>(); }

  Interaction interaction(int c) const override    // of the active pair c, for output
  {
    Interaction now = geometry(c);
    if (now.gap < 0.0) {
      now.state = CONTACT;
      now.elastic = law.normal_elastic(now.gap);
    }
    return now;
  }

  Energy energy(const Interaction &now) const override
  {
    Energy e;
    e.elastic = law.energy(now.gap);
    return e;
  }

  void write_restart(FILE *fp) override { write_law(fp, &law, sizeof(law)); }
  void read_restart(FILE *fp) override { read_law(fp, &law, sizeof(law)); }

private:
  disc::PairSums compute_active_pairs(bool stress) override { return pair_loop<Capped, false>(Capped{law}, stress); }

  CappedLaw law;
};

}    // namespace

extern "C" void lammpsplugin_init(void *lmp, void *handle, void *regfunc)
{
  require_version(lmp, "22 Jul 2025");
  stay_loaded();
  lammpsplugin_t plugin{"22 Jul 2025", "pair", "disc/capped", "a spring of limited force", "you", {}, handle};
  plugin.creator.v1 = &create_pair<PairDiscCapped>;
  reinterpret_cast<lammpsplugin_regfunc>(regfunc)(&plugin, lmp);
}
