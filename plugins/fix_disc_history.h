/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_HISTORY_H
#define LMP_FIX_DISC_HISTORY_H

#include "fix.h"
#include "kernels/sweep.h"

#include <vector>

namespace LAMMPS_NS
{

/* The neighbouring discs with the memory of their contacts; one mechanism for every law of this plugin.

   Three lists, each made from the one before: LAMMPS's neighbour list (gap < skin), `neighbours` (the same pairs,
   flat), and `close` (pairs that may act before the list is made again, with their memory), the only one that a force
   evaluation reads.  How far grains may have moved, relative to the affine motion of the cell, is counted step by step:
   when it uses up the margin of `close`, that list is made again; when it uses up the margin of `neighbours`, LAMMPS
   rebuilds its own.  No pair within `range` of touching is ever missed, whatever the cell does.

   Before atoms may move in memory (sorting, migration, restart) the memory is written to both grains of a contact,
   keyed by the partner's tag; afterwards it is read back.

   `grains` and `actions` are the kernel's copies of what LAMMPS holds: load() and store() carry over.

   Created by the pair style; not for use in a deck. */
class FixDiscHistory : public Fix
{
public:
  static constexpr const char *ID = "DISC_HISTORY";

  FixDiscHistory(class LAMMPS *, int, char **);
  ~FixDiscHistory() override;
  int setmask() override;
  void init() override;
  int modify_param(int, char **) override;
  void setup_pre_exchange() override;
  void setup_post_neighbor() override { post_neighbor(); }
  void post_integrate() override;
  void pre_exchange() override;
  void post_neighbor() override;
  void post_run() override;

  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  int pack_reverse_comm_size(int, int) override;
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  double memory_usage() override;

  // LAMMPS's arrays -> grains, actions; and back
  void load(int first, int last);
  void load_actions();
  void begin_actions();    // nothing but the weights of the grains of this rank
  void store() const;
  void store_actions() const;

  /* Grains of this rank moved by at most `largest` beyond the affine motion, the cell was stretched; collective. */
  void moved(double largest, const double *stretch);
  void require_number(double) const;
  bool rebuild_due() const { return margin <= 0.0; }
  bool choice_due() const { return close_margin <= 0.0; }
  void choose_close();                       // if it is due; collective
  disc::Extremes extremes_of_all() const;    // collective
  void rescale(double springs);              // what contacts remember, when the law changes
  void renew_viscosity();                    // after the law has changed
  int find(int i, int j) const;              // place in `close`, -1 if not there
  bool goes_on() const;                      // this step continues a run from its restart file, which holds its forces
  void restore_forces() const;
  bool current() const { return listed; }    // the lists belong to the grains and ghosts as they lie now

  std::vector<disc::Grain> grains;      // owned and ghosts
  std::vector<disc::Action> actions;    // zero between steps for ghosts
  disc::Contacts close;
  disc::Sums lost;                   // dissipated so far, of this rank; the pair style adds to it
  disc::Extremes extremes;           // of any step so far, of this rank; likewise
  disc::Motion motion;               // since the last evaluation
  bool second_order = false;         // see disc::Motion; set by the pair style
  double range = 0.0;                // gap up to which the law acts; set by the pair style
  double turned = -1.0;              // factor on the memory `rotation` seen from the other grain; set by the pair style
  double gravity[2] = {0.0, 0.0};    // set by fix disc/integrate, like the next
  int fixed = 0;                     // group bit of grains that do not move and have no weight

private:
  struct Neighbours {
    int i, j;
    double eta;
  };
  struct Partner {
    tagint tag;
    disc::Memory memory;    // seen from the owner of this entry: `rotation` is that of the partner relative to it
  };
  static constexpr int ENTRY = 8;    // doubles per partner on the wire
  static constexpr int FORCE = 3;    // doubles of the restored force and torque on the wire

  void remember();
  void follow();
  int pack_partners(int i, double *) const;
  int unpack_partners(int i, const double *);
  void require_unique_images(double reach) const;
  disc::Memory newly_close(const Neighbours &) const;

  std::vector<Neighbours> neighbours;
  std::vector<disc::Memory> memory;                 // of `neighbours` while `close` is being made
  std::vector<char> known;                          // has a memory
  std::vector<int> first;                           // in `neighbours`: those of grain i begin at first[i]
  std::vector<int> place;                           // in `close`, of each of `neighbours`; -1: not close
  std::vector<int> chosen;                          // those of `neighbours` that are close, in their order
  std::vector<std::vector<Partner>> partners;       // per atom, ghosts included while remembering
  std::vector<disc::Action> restored;               // per atom: force and torque of a run that goes on from a restart
  bigint restored_step = -1, restored_since = 0;    // that step; time counts from the other one
  double restored_time = 0.0;
  double last_cell[2] = {1.0, 1.0}, last_corner[2] = {0.0, 0.0};
  double largest_radius = 0.0;
  double margin = 0.0, close_margin = 0.0;    // left of the gap that no unlisted pair is below
  double pace = 0.0;                          // of that, used in the last step
  bool from_partners = false;                 // `memory` was filled when the neighbours were listed
  bool counted = false;                       // moved() was called in this step
  bool listed = false;                        // see current(); the partner lists may be older
};

}    // namespace LAMMPS_NS

#endif
