/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_HISTORY_H
#define LMP_FIX_DISC_HISTORY_H

#include "contact_list.h"
#include "fix.h"

#include <vector>

namespace LAMMPS_NS
{

/* The list of neighbouring discs with the memory of their contacts; one mechanism for every law of this plugin.

   Between two rebuilds of LAMMPS's neighbour list the memory lives in the records of `pairs`.  Before atoms may move
   (sorting, migration, restart) it is written to both grains of a contact, keyed by the partner's tag; afterwards it is
   read back into the new records.  The fix also decides when the list must be rebuilt: no pair within `range` of
   touching is ever missed, whatever the cell does, because the displacement is measured relative to its affine motion.

   Created by the pair style; not for use in a deck. */
class FixDiscHistory : public Fix
{
public:
  static constexpr const char *ID = "DISC_HISTORY";

  FixDiscHistory(class LAMMPS *, int, char **);
  ~FixDiscHistory() override;
  int setmask() override;
  void init() override;
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

  const disc::Neighbours *find(int i, int j) const;    // nullptr if the pair is not listed
  bool current() const { return listed; }              // the records belong to the grains and ghosts as they lie now

  std::vector<disc::Neighbours> pairs;
  disc::Loss loss;    // of this rank; the pair style adds to it
  double rate[2] = {0.0,
                    0.0};    // dL/dt / L per axis over the last step: the affine motion between two force evaluations
  double range = 0.0;        // gap up to which the law acts; set by the pair style

private:
  struct Partner {
    tagint tag;
    disc::Springs springs;    // seen from the owner of this entry: `rotation` is that of the partner relative to it
  };
  static constexpr int ENTRY = 3;    // doubles per partner on the wire

  void remember();
  void hold();
  void require_unique_images(double reach) const;

  std::vector<std::vector<Partner>> partners;    // per atom, ghosts included while remembering
  std::vector<int> first;                        // pairs of local atom i are first[i] .. first[i+1]-1
  std::vector<double> held;                      // positions at the last rebuild, relative to the cell corner
  double held_cell[2] = {1.0, 1.0};
  double last_cell[2] = {0.0, 0.0};
  double largest_radius = 0.0;
  bool listed = false;    // see current(); the partner lists may be older
};

}    // namespace LAMMPS_NS

#endif
