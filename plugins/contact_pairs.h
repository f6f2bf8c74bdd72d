/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_CONTACT_PAIRS_H
#define LMP_CONTACT_PAIRS_H

#include "pair_disc.h"
#include "pointers.h"

#include <utility>
#include <vector>

namespace LAMMPS_NS
{

/* The interacting pairs of any pair style of contacts, for fixes that look at them.

   Pair styles of this plugin tell what acted in the last evaluation.  Those of LAMMPS (granular, gran/...), alone or
   with disc/tail in hybrid/overlay, are asked pair by pair through Pair::single() with the velocities of now; the part
   of the normal force that is not attraction counts as elastic, since they do not tell it from the viscous one. */
class ContactPairs : protected Pointers
{
public:
  explicit ContactPairs(class LAMMPS *lmp) : Pointers(lmp) {}
  void init(const char *user);    // finds the pair style, or says why `user` cannot work with it

  PairDisc *ours() const { return own; }    // the pair style of this plugin, if it is one
  double cutoff_gap() const { return own ? own->cutoff_gap() : range; }

  /* As PairDisc::for_each_pair(); collective only in that every rank must call refresh() before. */
  template <class Visit> void for_each_pair(Visit visit) const
  {
    if (own) {
      own->for_each_pair(visit);
      return;
    }
    for (const Listed &one : listed)
      visit(one.i, one.j, one.now, one.weight);
  }

  void refresh();    // pairs and velocities as they are now, also of ghosts; collective
  double approach(int i, int j, const PairDisc::Interaction &) const;    // speed at which the two grains close in

private:
  struct Listed {
    int i, j;
    PairDisc::Interaction now;
    double weight;
  };
  template <class Interacts> void add_pairs(const class NeighList *, Interacts);
  double normal_force(class Pair *, int i, int j, double distance) const;
  void list_contacts();
  void list_tail();
  PairDisc::Interaction geometry(int i, int j) const;
  double weight(int j) const;

  PairDisc *own = nullptr;
  class Pair *contact = nullptr, *tail = nullptr;    // of LAMMPS; disc/tail
  double range = 0.0;                                // of the attraction
  std::vector<Listed> listed;
  const std::vector<disc::Grain> *grains = nullptr;
};

}    // namespace LAMMPS_NS

#endif
