/* SPDX-License-Identifier: GPL-2.0-or-later */

#ifndef LMP_FIX_DISC_HISTORY_H
#define LMP_FIX_DISC_HISTORY_H

#include "disc_state.h"
#include "fix.h"
#include "pair_list.h"

#include <vector>

namespace LAMMPS_NS
{

/* The contact history as LAMMPS carries it: with the grains through list rebuilds, sorting, migration and restarts; one
   mechanism for every law of this plugin.

   Before atoms may move in memory the history of the active pairs is written to both grains of a contact, keyed by the
   partner's tag; afterwards it is read back.  Also kept: the forces of a restart file that was written within a run.

   Created by the pair style; not for use in a deck, but for

     fix_modify DISC_HISTORY forces anew      the next run starts as any other, not as the rest of an interrupted one */
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

  bool continues_restart() const;    // this step continues a run from its restart file, which holds its forces
  void restore_forces() const;
  bool up_to_date() const { return listed; }    // the lists belong to the grains and ghosts as they lie now

  DiscState state;
  PairList pairs;

private:
  struct Partner {
    tagint tag;
    disc::ContactHistory history;    // seen from the owner of this entry
  };
  static constexpr int FORCE = 3;    // doubles of the restored force and torque on the wire

  int entry() const { return 1 + pairs.columns.count; }    // doubles of a partner on the wire
  void write_to_partners();
  const disc::ContactHistory *saved_history(int i, tagint tag) const;
  int pack_partners(int i, double *) const;
  int unpack_partners(int i, const double *);

  std::vector<std::vector<Partner>> partners;       // per atom, ghosts included while they are written
  std::vector<disc::GrainForce> restored;           // per atom: force and torque of a run that goes on from a restart
  bigint restored_step = -1, restored_since = 0;    // that step; time counts from the other one
  double restored_time = 0.0;
  bool listed = false;    // see up_to_date(); the partner lists may be older
};

}    // namespace LAMMPS_NS

#endif
