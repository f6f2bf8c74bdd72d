/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_PAIR_LIST_H
#define LMP_PAIR_LIST_H

#include "disc_state.h"
#include "kernels/pair_loop.h"
#include "pointers.h"

#include <functional>
#include <vector>

namespace LAMMPS_NS
{

/* The active pairs of discs, and when to list them anew.

   Three lists, each made from the one before: LAMMPS's neighbour list (gap < skin), `neighbors` (the same pairs, flat),
   and `active` (pairs that may interact before the list is made again, with their contact history), the only one that a
   force evaluation reads.  How far grains may have moved, relative to the affine motion of the cell, is counted step by
   step: when it uses up the skin of `active`, that list is made again; when it uses up the skin of `neighbors`, LAMMPS
   rebuilds its own.  No pair within `cutoff_gap` of contact is ever missed, whatever the cell does. */
class PairList : protected Pointers
{
public:
  using Saved = std::function<const disc::ContactHistory *(int i, tagint tag_j)>;    // null: the pair has none

  PairList(class LAMMPS *lmp, DiscState &state) : Pointers(lmp), state(state) {}

  void build(const class PairDisc &law, const Saved &saved);    // from LAMMPS's neighbour list
  void rebuild_pair_list(class PairDisc &law);                  // `active` from `neighbors`, if it is due; collective
  bool neighbor_list_due() const { return skin_left <= 0.0; }
  bool pair_list_due() const { return active_skin_left <= 0.0; }

  /* Grains of this rank moved by at most `largest` beyond the affine motion, the cell was scaled; collective. */
  void record_displacement(double largest, const double *cell_scaling);
  void track_displacement();    // the same from LAMMPS's positions, unless it was recorded in this step
  void mark_cell();             // positions are those of the cell as it is now
  void require_number(double sum) const;

  void scale_springs(double factor);                        // elastic displacements, when the stiffness changes
  void update_pair_constants(const class PairDisc &law);    // after the law has changed
  int find(int i, int j) const;                             // place in `active`, -1 if not there
  double memory_usage() const;

  disc::ActivePairs active;
  disc::HistoryColumns columns;      // of the law; set by the pair style, like the next two
  bool second_order = false;         // see disc::StepKinematics
  double cutoff_gap = 0.0;           // gap up to which the law acts
  double last_displacement = 0.0;    // skin used in the last step

private:
  struct Neighbor {
    int i, j;
    double pair_constant;
  };

  void read_histories();
  void select_pairs();
  void require_unique_images(double reach) const;
  disc::ContactHistory new_pair_history(const Neighbor &) const;

  DiscState &state;
  std::vector<Neighbor> neighbors;
  std::vector<disc::ContactHistory> history;    // of `neighbors` while `active` is being made
  std::vector<char> has_history;
  std::vector<int> first;           // in `neighbors`: those of grain i begin at first[i]
  std::vector<int> active_index;    // in `active`, of each of `neighbors`; -1: not active
  std::vector<int> selected;        // those of `neighbors` that become active, in their order
  double last_cell[2] = {1.0, 1.0}, last_corner[2] = {0.0, 0.0};
  double largest_radius = 0.0;
  double skin_left = 0.0, active_skin_left = 0.0;    // of the gap that no unlisted pair is below
  bool newly_built = false;                          // `history` was filled when the neighbours were listed
  bool recorded = false;                             // record_displacement() was called in this step
};

}    // namespace LAMMPS_NS

#endif
