/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_history.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "neighbor.h"
#include "pair_disc.h"
#include "rank_sums.h"
#include "update.h"

#include <algorithm>
#include <cstring>

using namespace LAMMPS_NS;
using disc::ContactHistory;

FixDiscHistory::FixDiscHistory(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg), state(lmp), pairs(lmp, state)
{
  const auto *law = dynamic_cast<PairDisc *>(force->pair);
  if (!law) error->all(FLERR, "fix disc/history is created by the pair styles of its plugin, such as disc/cohesive");
  pairs.columns = law->history_columns();
  restart_global = 1;
  restart_peratom = 1;
  force_reneighbor = 1;
  next_reneighbor = -1;
  create_attribute = 1;
  maxexchange_dynamic = 1;
  comm_reverse = 1;    // real sizes come from pack_reverse_comm_size
  FixDiscHistory::grow_arrays(atom->nmax);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
}

FixDiscHistory::~FixDiscHistory()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
}

int FixDiscHistory::setmask()
{
  using namespace FixConst;
  return POST_INTEGRATE | PRE_EXCHANGE | POST_NEIGHBOR | POST_RUN;
}

void FixDiscHistory::init()
{
  listed = false;    // what follows (a run, write_restart, write_data) may move grains and ghosts to other places
  if (neighbor->skin <= pairs.cutoff_gap)
    error->all(FLERR,
               "neighbor skin {} must exceed the range {} of the attraction (keyword d0), or pairs would be missed: "
               "use 'neighbor {} bin' or more",
               neighbor->skin, pairs.cutoff_gap, 2.0 * pairs.cutoff_gap);
}

/* ---- in a step ---- */

void FixDiscHistory::post_integrate()
{
  pairs.track_displacement();
  if (pairs.neighbor_list_due()) next_reneighbor = update->ntimestep;
}

void FixDiscHistory::setup_pre_exchange()
{
  if (continues_restart()) {
    update->atime = restored_time;
    update->atimestep = restored_since;
  }
  pairs.mark_cell();
  pre_exchange();
}

void FixDiscHistory::pre_exchange()
{
  if (listed) write_to_partners();
  listed = false;
}

/* The active pairs stay valid: a run with `pre no` goes on with them. */
void FixDiscHistory::post_run()
{
  if (listed) write_to_partners();
}

/* ---- from the active pairs to the grains ---- */

void FixDiscHistory::write_to_partners()
{
  const int nlocal = atom->nlocal;
  const int nall = nlocal + atom->nghost;
  const bool newton = force->newton_pair;
  const tagint *tag = atom->tag;
  const disc::ActivePairs &active = pairs.active;
  if (static_cast<int>(partners.size()) < nall) partners.resize(nall);
  for (int i = 0; i < nall; i++)
    partners[i].clear();
  for (int c = 0; c < active.count; c++) {
    const ContactHistory h = active.history_of(c);
    const int i = active.i[c], j = active.j[c];
    if (pairs.columns.empty(h)) continue;
    partners[i].push_back({tag[j], h});
    // with newton off the owner of a ghost has an active pair of its own
    if (newton || j < nlocal) partners[j].push_back({tag[i], pairs.columns.exchanged(h)});
  }
  if (newton) comm->reverse_comm_variable(this);
  maxexchange = FORCE + 1;
  for (int i = 0; i < nlocal; i++)
    maxexchange = std::max(maxexchange, FORCE + 1 + entry() * static_cast<int>(partners[i].size()));
}

/* ---- from the grains to the active pairs ---- */

void FixDiscHistory::post_neighbor()
{
  auto *law = dynamic_cast<PairDisc *>(force->pair);
  pairs.build(*law, [this](int i, tagint tag) { return saved_history(i, tag); });
  state.resize();
  law->ghosts.invalidate();
  listed = true;
}

const ContactHistory *FixDiscHistory::saved_history(int i, tagint tag) const
{
  const ContactHistory *found = nullptr;
  for (const Partner &partner : partners[i])
    if (partner.tag == tag) found = &partner.history;
  return found;
}

/* ---- per-atom bookkeeping of LAMMPS ---- */

void FixDiscHistory::grow_arrays(int nmax)
{
  if (static_cast<int>(partners.size()) < nmax) partners.resize(nmax);
  if (static_cast<int>(restored.size()) < nmax) restored.resize(nmax);
}

void FixDiscHistory::copy_arrays(int i, int j, int /*delflag*/)
{
  partners[j] = partners[i];
  restored[j] = restored[i];
}

void FixDiscHistory::set_arrays(int i) { partners[i].clear(); }

int FixDiscHistory::pack_partners(int i, double *buf) const
{
  int m = 0;
  buf[m++] = static_cast<double>(partners[i].size());
  for (const Partner &p : partners[i]) {
    buf[m++] = ubuf(p.tag).d;
    for (int column = 0; column < pairs.columns.count; column++)
      buf[m++] = p.history[column];
  }
  return m;
}

/* Appends to the partners of i. */
int FixDiscHistory::unpack_partners(int i, const double *buf)
{
  int m = 0;
  for (int count = static_cast<int>(buf[m++]); count > 0; count--) {
    Partner p{static_cast<tagint>(ubuf(buf[m]).i), {}};
    std::copy(buf + m + 1, buf + m + entry(), p.history.begin());
    partners[i].push_back(p);
    m += entry();
  }
  return m;
}

int FixDiscHistory::pack_exchange(int i, double *buf)
{
  buf[0] = restored[i].fx;
  buf[1] = restored[i].fy;
  buf[2] = restored[i].moment;
  return FORCE + pack_partners(i, buf + FORCE);
}

int FixDiscHistory::unpack_exchange(int i, double *buf)
{
  restored[i] = {buf[0], buf[1], buf[2], 0.0};
  partners[i].clear();
  return FORCE + unpack_partners(i, buf + FORCE);
}

int FixDiscHistory::pack_reverse_comm_size(int n, int first_ghost)
{
  int size = 0;
  for (int i = first_ghost; i < first_ghost + n; i++)
    size += 1 + entry() * static_cast<int>(partners[i].size());
  return size;
}

int FixDiscHistory::pack_reverse_comm(int n, int first_ghost, double *buf)
{
  int m = 0;
  for (int i = first_ghost; i < first_ghost + n; i++)
    m += pack_partners(i, buf + m);
  return m;
}

void FixDiscHistory::unpack_reverse_comm(int n, int *list, double *buf)
{
  int m = 0;
  for (int k = 0; k < n; k++)
    m += unpack_partners(list[k], buf + m);
}

/* ---- restart ---- */

/* First value: minus the number of history columns; files of version 0.3 and before begin with a length, which is not
   negative, and have other columns. */
void FixDiscHistory::write_restart(FILE *fp)
{
  // history may be newer in the active pairs than with the partners: the restart step's own force evaluation came since
  if (listed) write_to_partners();
  const disc::Extremes largest = state.global_extremes();
  // outside a run the next one evaluates forces anew in any case
  const double within_run = update->whichflag == 1 ? 1.0 : 0.0;
  // LAMMPS stores the time of this step; rounding differs from that of the run that counts on
  const double since = ubuf(update->atimestep).d;
  const double *const affine_rate = state.kinematics.affine_rate;
  std::vector<double> saved = {-static_cast<double>(pairs.columns.count),
                               pairs.last_displacement,
                               within_run,
                               update->atime,
                               since,
                               affine_rate[0],
                               affine_rate[1],
                               largest.overlap,
                               largest.approach,
                               largest.advance};
  save_rank_sums(world, {state.dissipated.viscous, state.dissipated.sliding, state.dissipated.rolling}, saved);
  if (comm->me == 0) {
    const int size = static_cast<int>(saved.size() * sizeof(double));
    fwrite(&size, sizeof(int), 1, fp);
    fwrite(saved.data(), size, 1, fp);
  }
}

void FixDiscHistory::restart(char *buf)
{
  const auto *saved = reinterpret_cast<const double *>(buf);
  if (saved[0] != -static_cast<double>(pairs.columns.count))
    error->all(FLERR, "the restart file has the contact history of another version of the plugin or of another law; "
                      "start the run anew");
  pairs.last_displacement = saved[1];
  restored_step = saved[2] > 0.0 ? update->ntimestep : -1;
  restored_time = saved[3];
  double since = saved[4];
  restored_since = static_cast<bigint>(ubuf(since).i);
  std::copy(saved + 5, saved + 7, state.kinematics.affine_rate);    // of the cell as it moves, also for new forces
  state.extremes = {saved[7], saved[8], saved[9]};
  const std::vector<double> sums = restore_rank_sums(world, saved + 10, 3);
  state.dissipated.viscous = sums[0];
  state.dissipated.sliding = sums[1];
  state.dissipated.rolling = sums[2];
}

int FixDiscHistory::modify_param(int narg, char **arg)
{
  if (narg < 2 || strcmp(arg[0], "forces") != 0 || strcmp(arg[1], "anew") != 0) return 0;
  restored_step = -1;
  return 2;
}

bool FixDiscHistory::continues_restart() const { return update->ntimestep == restored_step; }

void FixDiscHistory::restore_forces() const
{
  for (int i = 0; i < atom->nlocal; i++) {
    atom->f[i][0] = restored[i].fx;
    atom->f[i][1] = restored[i].fy;
    atom->torque[i][2] = restored[i].moment;
  }
}

int FixDiscHistory::pack_restart(int i, double *buf)
{
  buf[1] = atom->f[i][0];
  buf[2] = atom->f[i][1];
  buf[3] = atom->torque[i][2];
  const int m = 1 + FORCE + pack_partners(i, buf + 1 + FORCE);
  buf[0] = m;
  return m;
}

void FixDiscHistory::unpack_restart(int nlocal, int nth)
{
  double *extra = atom->extra[nlocal];
  int m = 0;
  for (int k = 0; k < nth; k++)
    m += static_cast<int>(extra[m]);
  unpack_exchange(nlocal, extra + m + 1);
}

int FixDiscHistory::size_restart(int i) { return 2 + FORCE + entry() * static_cast<int>(partners[i].size()); }

int FixDiscHistory::maxsize_restart()
{
  int largest = 0;
  for (const auto &list : partners)
    largest = std::max(largest, static_cast<int>(list.size()));
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_INT, MPI_MAX, world);
  return 2 + FORCE + entry() * largest;
}

double FixDiscHistory::memory_usage()
{
  double bytes = state.memory_usage() + pairs.memory_usage() + restored.capacity() * sizeof(disc::GrainForce) +
                 partners.capacity() * sizeof(partners[0]);
  for (const auto &list : partners)
    bytes += list.capacity() * sizeof(Partner);
  return bytes;
}
