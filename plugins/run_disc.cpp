/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "run_disc.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_disc_feed.h"
#include "fix_disc_history.h"
#include "fix_disc_integrate.h"
#include "force.h"
#include "modify.h"
#include "neighbor.h"
#include "output.h"
#include "pair_disc.h"
#include "timer.h"
#include "update.h"

#include <algorithm>

using namespace LAMMPS_NS;

RunDisc::RunDisc(LAMMPS *lmp, int narg, char **arg) : Verlet(lmp, narg, arg)
{
  if (narg > 0) error->all(FLERR, "run_style verlet/disc takes no arguments, not '{}'", arg[0]);
}

void RunDisc::run(int n)
{
  const bool only_ours = find_styles();
  const bigint end = update->ntimestep + n;
  for (int i = 0; i < n; i++) {
    if (timer->check_timeout(i)) {
      update->nsteps = i;
      return;
    }
    if (only_ours) {
      const bigint before = update->ntimestep;
      run_unobserved(next_observed_step(end) - 1);
      i += static_cast<int>(update->ntimestep - before);
    }
    Verlet::run(1);
  }
}

/* Nothing but our own styles acts within a step; insertion does at intervals. */
bool RunDisc::find_styles()
{
  pair = dynamic_cast<PairDisc *>(force->pair);
  history = dynamic_cast<FixDiscHistory *>(modify->get_fix_by_id(FixDiscHistory::ID));
  integrate = nullptr;
  feed = nullptr;
  const int within = FixConst::INITIAL_INTEGRATE | FixConst::POST_INTEGRATE | FixConst::PRE_EXCHANGE |
                     FixConst::PRE_NEIGHBOR | FixConst::POST_NEIGHBOR | FixConst::PRE_FORCE | FixConst::PRE_REVERSE |
                     FixConst::POST_FORCE | FixConst::FINAL_INTEGRATE;
  for (int k = 0; k < modify->nfix; k++) {
    Fix *const fix = modify->fix[k];
    if (fix == history) continue;
    if (auto *const ours = dynamic_cast<FixDiscIntegrate *>(fix)) {
      if (integrate) return false;
      integrate = ours;
    } else if (auto *const insertion = dynamic_cast<FixDiscFeed *>(fix)) {
      if (feed) return false;
      feed = insertion;
    } else if ((modify->fmask[k] & within) || fix->force_reneighbor) {
      return false;
    }
  }
  return pair && history && integrate && !force->kspace && atom->molecular == Atom::ATOMIC && !domain->triclinic;
}

bigint RunDisc::next_observed_step(bigint last) const
{
  bigint next = std::min(last, output->next);
  for (int k = 0; k < modify->nfix; k++)
    if ((modify->fmask[k] & FixConst::END_OF_STEP) || modify->fix[k] == feed) {
      const bigint every = modify->fix[k]->nevery;
      next = std::min(next, (update->ntimestep / every + 1) * every);
    }
  return next;
}

/* Up to and with step `last`; LAMMPS's arrays are true before and after. */
void RunDisc::run_unobserved(bigint last)
{
  if (update->ntimestep >= last) return;
  timer->stamp();
  history->state.load(0, atom->nlocal + atom->nghost);
  history->state.load_forces();
  bool step_begun = false;
  while (update->ntimestep < last) {
    update->ntimestep++;
    neighbor->ago++;
    integrate->integrate(step_begun, true);
    step_begun = true;
    timer->stamp(Timer::MODIFY);
    if (history->pairs.neighbor_list_due()) {
      rebuild();
      timer->stamp(Timer::NEIGH);
    } else {
      pair->ghosts.forward_comm(history->state.grains, history->pairs.pair_list_due());
      timer->stamp(Timer::COMM);
    }
    pair->evaluate();
    timer->stamp(Timer::PAIR);
    if (force->newton_pair) pair->ghosts.reverse_comm(history->state.forces);
    timer->stamp(Timer::COMM);
  }
  integrate->integrate(true, false);
  history->state.store();
  history->state.store_forces();
  timer->stamp(Timer::MODIFY);
}

/* As Verlet::run() does when lists are due. */
void RunDisc::rebuild()
{
  history->state.store();
  modify->pre_exchange();
  domain->pbc();
  if (domain->box_change) {
    domain->reset_box();
    comm->setup();
    neighbor->setup_bins();
  }
  comm->exchange();
  if (atom->sortfreq > 0 && update->ntimestep >= atom->nextsort) atom->sort();
  comm->borders();
  neighbor->build(1);
  modify->post_neighbor();
  history->state.load(0, atom->nlocal + atom->nghost);
}
