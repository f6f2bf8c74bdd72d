/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_history.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_disc.h"
#include "rank_sums.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using disc::Grain;
using PairMemory = disc::Memory;

FixDiscHistory::FixDiscHistory(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
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
  if (neighbor->skin <= range)
    error->all(FLERR,
               "neighbor skin {} must exceed the range {} of the attraction (keyword d0), or pairs would be missed: "
               "use 'neighbor {} bin' or more",
               neighbor->skin, range, 2.0 * range);
}

/* ---- LAMMPS's arrays and the kernel's ---- */

void FixDiscHistory::load(int from, int to)
{
  const double *const x = atom->x[0], *const v = atom->v[0], *const w = atom->omega[0], *const r = atom->radius,
                      *const m = atom->rmass;
  for (int i = from, k = 3 * from; i < to; i++, k += 3)
    grains[i] = {x[k],     x[k + 1],        v[k], v[k + 1],
                 w[k + 2], r[i] * w[k + 2], r[i], atom->mask[i] & fixed ? 0.0 : 1.0 / m[i]};
}

void FixDiscHistory::load_actions()
{
  const double *const f = atom->f[0], *const torque = atom->torque[0];
  for (int i = 0, k = 0; i < atom->nlocal; i++, k += 3)
    actions[i] = {f[k], f[k + 1], torque[k + 2], 0.0};
}

void FixDiscHistory::begin_actions()
{
  std::fill(actions.begin(), actions.end(), disc::Action());
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & fixed)) {
      actions[i].fx = atom->rmass[i] * gravity[0];
      actions[i].fy = atom->rmass[i] * gravity[1];
    }
}

void FixDiscHistory::store() const
{
  double *const x = atom->x[0], *const v = atom->v[0], *const w = atom->omega[0];
  for (int i = 0, k = 0; i < atom->nlocal; i++, k += 3) {
    const Grain &g = grains[i];
    x[k] = g.x;
    x[k + 1] = g.y;
    v[k] = g.vx;
    v[k + 1] = g.vy;
    w[k + 2] = g.w;
  }
}

void FixDiscHistory::store_actions() const
{
  double *const f = atom->f[0], *const torque = atom->torque[0];
  for (int i = 0, k = 0; i < atom->nlocal; i++, k += 3) {
    const disc::Action &a = actions[i];
    f[k] = a.fx;
    f[k + 1] = a.fy;
    torque[k + 2] = a.moment + grains[i].r * a.tangential;
  }
}

/* ---- how far grains moved ---- */

/* Two centres at a distance b come to s b - 2 u at least, with u the largest displacement beyond the affine motion and
   s < 1 the smaller stretch of the cell; unlisted pairs are less than 2 R + skin apart where it matters. */
void FixDiscHistory::moved(double largest, const double *stretch)
{
  const double dt = update->dt;
  motion.dt = dt;
  for (int a = 0; a < 2; a++) {
    const double s = stretch[a], mean = 0.5 * (1.0 + s);
    motion.carry[a] = second_order ? mean / s : 1.0;
    motion.affine[a] = (s - 1.0) / ((second_order ? s : mean) * dt);
  }
  motion.ahead = second_order ? 0.5 : 0.0;
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  const double smallest = std::min({1.0, stretch[0], stretch[1]});
  pace = 2.0 * largest + (1.0 - smallest) * (2.0 * largest_radius + neighbor->skin);
  margin -= pace;
  close_margin -= pace;
  for (int a = 0; a < 2; a++) {
    last_cell[a] = domain->prd[a];
    last_corner[a] = domain->boxlo[a];
  }
  counted = true;
}

/* For integrators that do not call moved(): `grains` still holds the positions of the last evaluation. */
void FixDiscHistory::post_integrate()
{
  if (!counted) follow();
  counted = false;
  if (margin <= 0.0) next_reneighbor = update->ntimestep;
}

void FixDiscHistory::follow()
{
  const double stretch[2] = {domain->prd[0] / last_cell[0], domain->prd[1] / last_cell[1]};
  double largest = 0.0, sum = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    const double ux = atom->x[i][0] - domain->boxlo[0] - stretch[0] * (grains[i].x - last_corner[0]);
    const double uy = atom->x[i][1] - domain->boxlo[1] - stretch[1] * (grains[i].y - last_corner[1]);
    largest = std::max(largest, ux * ux + uy * uy);
    sum += ux * ux + uy * uy;    // remembers a NaN, which a maximum forgets
  }
  require_number(sum);
  moved(std::sqrt(largest), stretch);
}

void FixDiscHistory::require_number(double sum) const
{
  if (!std::isfinite(sum))
    error->one(
        FLERR,
        "the position of a grain is not a number at step {}: centres of two grains coincide, or the step {} is far too "
        "large",
        update->ntimestep, update->dt);
}

/* ---- the close pairs ---- */

/* The wider the margin, the more pairs that do not act; the narrower, the more often this is done: the sum costs least
   with a margin that grows like the root of the pace (measured: 0.2 R times it, dense and gas alike).

   Pairs of one grain are neighbours in the list.  Within a block they are dealt out, so that the kernel does not read a
   record back that it has just written: the processor would wait for it. */
void FixDiscHistory::choose_close()
{
  if (!choice_due()) return;
  if (!from_partners) {
    memory.assign(neighbours.size(), PairMemory());
    known.assign(neighbours.size(), 0);
    for (int c = 0; c < close.count; c++) {
      memory[close.at[c]] = close.memory(c);
      known[close.at[c]] = 1;
    }
  }
  from_partners = false;
  close_margin = std::min(margin, std::max(1.0e-4 * largest_radius, std::sqrt(0.2 * largest_radius * pace)));
  const double reach = range + close_margin;
  chosen.clear();
  for (int k = 0; k < static_cast<int>(neighbours.size()); k++) {
    const Grain &a = grains[neighbours[k].i], &b = grains[neighbours[k].j];
    const double bx = b.x - a.x, by = b.y - a.y, apart = a.r + b.r + reach;
    if (bx * bx + by * by < apart * apart) chosen.push_back(k);
  }
  place.assign(neighbours.size(), -1);
  close.clear();
  const int count = static_cast<int>(chosen.size());
  for (int start = 0; start < count; start += disc::BLOCK) {
    const int end = std::min(start + disc::BLOCK, count), stride = (end - start + disc::LANES - 1) / disc::LANES;
    for (int offset = start; offset < start + stride; offset++)
      for (int c = offset; c < end; c += stride) {
        const int k = chosen[c];
        const Neighbours &p = neighbours[k];
        place[k] = close.count;
        close.add(p.i, p.j, k, p.eta, known[k] ? memory[k] : newly_close(p));
      }
  }
  close.pad();
  dynamic_cast<PairDisc *>(force->pair)->ghosts.name(close);
}

void FixDiscHistory::rescale(double springs)
{
  for (int c = 0; c < close.count; c++) {
    close.stretch[c] *= springs;
    close.rotation[c] *= springs;
  }
}

/* Computed from the law as it is now, as when lists are made: a run that resumes here has the same bits. */
void FixDiscHistory::renew_viscosity()
{
  const auto *law = dynamic_cast<PairDisc *>(force->pair);
  for (Neighbours &p : neighbours)
    p.eta = law->viscosity(p.i, p.j);
  for (int c = 0; c < close.count; c++)
    close.eta[c] = neighbours[close.at[c]].eta;
}

/* d|b|/dt and the sliding velocity in the middle of the step, as the kernels compute them (the latter for discs that
   touch) */
PairMemory FixDiscHistory::newly_close(const Neighbours &p) const
{
  if (!second_order) return {};
  const Grain &a = grains[p.i], &b = grains[p.j];
  const double bx = b.x - a.x, by = b.y - a.y, distance = std::sqrt(bx * bx + by * by);
  const double ux = motion.carry[0] * (b.vx - a.vx) + motion.affine[0] * bx;
  const double uy = motion.carry[1] * (b.vy - a.vy) + motion.affine[1] * by;
  const double un = (bx * ux + by * uy) / distance, ut = (bx * uy - by * ux) / distance;
  const double turn = 0.5 * motion.dt * ut / distance;
  return {0.0, 0.0, un - turn * ut, ut + turn * un - (a.rw + b.rw)};
}

disc::Extremes FixDiscHistory::extremes_of_all() const
{
  double most[3] = {extremes.overlap, extremes.approach, extremes.advance};
  MPI_Allreduce(MPI_IN_PLACE, most, 3, MPI_DOUBLE, MPI_MAX, world);
  return {most[0], most[1], most[2]};
}

/* ---- from the records to the grains ---- */

void FixDiscHistory::setup_pre_exchange()
{
  if (goes_on()) {
    update->atime = restored_time;
    update->atimestep = restored_since;
  }
  for (int a = 0; a < 2; a++) {
    last_cell[a] = domain->prd[a];
    last_corner[a] = domain->boxlo[a];
  }
  pre_exchange();
}

void FixDiscHistory::pre_exchange()
{
  if (listed) remember();
  listed = false;
}

/* The records stay valid: a run with `pre no` goes on with them. */
void FixDiscHistory::post_run()
{
  if (listed) remember();
}

void FixDiscHistory::remember()
{
  const int nlocal = atom->nlocal;
  const int nall = nlocal + atom->nghost;
  const bool newton = force->newton_pair;
  const tagint *tag = atom->tag;
  if (static_cast<int>(partners.size()) < nall) partners.resize(nall);
  for (int i = 0; i < nall; i++)
    partners[i].clear();
  for (int c = 0; c < close.count; c++) {
    const PairMemory m = close.memory(c);
    const int i = close.i[c], j = close.j[c];
    if (m.empty()) continue;
    partners[i].push_back({tag[j], m});
    // with newton off the owner of a ghost has a record of its own
    if (newton || j < nlocal) partners[j].push_back({tag[i], m.seen_from_other(turned)});
  }
  if (newton) comm->reverse_comm_variable(this);
  maxexchange = FORCE + 1;
  for (int i = 0; i < nlocal; i++)
    maxexchange = std::max(maxexchange, FORCE + 1 + ENTRY * static_cast<int>(partners[i].size()));
}

/* ---- from the grains to the records ---- */

void FixDiscHistory::post_neighbor()
{
  auto *law = dynamic_cast<PairDisc *>(force->pair);
  const NeighList *list = law->list;
  const double *radius = atom->radius;
  const tagint *tag = atom->tag;
  const int nlocal = atom->nlocal;

  largest_radius = 0.0;
  for (int i = 0; i < nlocal; i++)
    largest_radius = std::max(largest_radius, radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest_radius, 1, MPI_DOUBLE, MPI_MAX, world);
  require_unique_images(2.0 * largest_radius + neighbor->skin);

  neighbours.clear();
  memory.clear();
  known.clear();
  first.assign(nlocal, 0);
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    first[i] = static_cast<int>(neighbours.size());
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      neighbours.push_back({i, j, law->viscosity(i, j)});
      memory.emplace_back();
      known.push_back(0);
      for (const Partner &partner : partners[i])
        if (partner.tag == tag[j]) {
          memory.back() = partner.memory;
          known.back() = 1;
        }
    }
  }
  grains.resize(nlocal + atom->nghost);
  actions.resize(nlocal + atom->nghost);
  begin_actions();
  law->ghosts.forget();
  margin = neighbor->skin - range;
  close_margin = 0.0;    // `close` is made before the next evaluation
  from_partners = true;
  listed = true;
}

void FixDiscHistory::require_unique_images(double reach) const
{
  for (int a = 0; a < 2; a++)
    if (domain->periodicity[a] && domain->prd[a] < 2.0 * reach)
      error->all(
          FLERR,
          "cell length {} along {} is below {} = 2 (largest diameter + skin): two images of one grain could touch "
          "the same grain; use a larger cell or more grains",
          domain->prd[a], a ? 'y' : 'x', 2.0 * reach);
}

int FixDiscHistory::find(int i, int j) const
{
  for (int k = first[i]; k < static_cast<int>(neighbours.size()) && neighbours[k].i == i; k++)
    if (neighbours[k].j == j) return place[k];
  return -1;
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
    buf[m++] = p.memory.stretch;
    buf[m++] = p.memory.rotation;
    buf[m++] = p.memory.speed;
    buf[m++] = p.memory.sideways;
    buf[m++] = p.memory.viscous;
    buf[m++] = p.memory.viscous_t;
    buf[m++] = p.memory.viscous_r;
  }
  return m;
}

/* appends */
int FixDiscHistory::unpack_partners(int i, const double *buf)
{
  int m = 0;
  for (int count = static_cast<int>(buf[m++]); count > 0; count--) {
    partners[i].push_back({static_cast<tagint>(ubuf(buf[m]).i),
                           {buf[m + 1], buf[m + 2], buf[m + 3], buf[m + 4], buf[m + 5], buf[m + 6], buf[m + 7]}});
    m += ENTRY;
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
    size += 1 + ENTRY * static_cast<int>(partners[i].size());
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

void FixDiscHistory::write_restart(FILE *fp)
{
  // memory may be newer in the records than in the partner lists: the restart step's own force evaluation came since
  if (listed) remember();
  const disc::Extremes most = extremes_of_all();
  const double within_run =
      update->whichflag == 1 ? 1.0 : 0.0;    // else the next run evaluates forces anew in any case
  // LAMMPS stores the time of this step; rounding differs from that of the run that counts on
  const double since = ubuf(update->atimestep).d;
  std::vector<double> state = {pace,         within_run,   update->atime, since,       motion.affine[0], motion.affine[1],
                               most.overlap, most.approach, most.advance};
  save_rank_sums(world, {lost.viscous, lost.sliding, lost.rolling}, state);
  if (comm->me == 0) {
    const int size = static_cast<int>(state.size() * sizeof(double));
    fwrite(&size, sizeof(int), 1, fp);
    fwrite(state.data(), size, 1, fp);
  }
}

void FixDiscHistory::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  pace = state[0];
  restored_step = state[1] > 0.0 ? update->ntimestep : -1;
  restored_time = state[2];
  double since = state[3];
  restored_since = static_cast<bigint>(ubuf(since).i);
  std::copy(state + 4, state + 6, motion.affine);    // of the cell as it moves, also for forces evaluated anew
  extremes = {state[6], state[7], state[8]};
  const std::vector<double> sums = restore_rank_sums(world, state + 9, 3);
  lost.viscous = sums[0];
  lost.sliding = sums[1];
  lost.rolling = sums[2];
}

/* fix_modify DISC_HISTORY forces anew: the run that ended with the restart file is over, the next one starts as any
 * other */
int FixDiscHistory::modify_param(int narg, char **arg)
{
  if (narg < 2 || strcmp(arg[0], "forces") != 0 || strcmp(arg[1], "anew") != 0) return 0;
  restored_step = -1;
  return 2;
}

bool FixDiscHistory::goes_on() const { return update->ntimestep == restored_step; }

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

int FixDiscHistory::size_restart(int i) { return 2 + FORCE + ENTRY * static_cast<int>(partners[i].size()); }

int FixDiscHistory::maxsize_restart()
{
  int most = 0;
  for (const auto &list : partners)
    most = std::max(most, static_cast<int>(list.size()));
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, world);
  return 2 + FORCE + ENTRY * most;
}

double FixDiscHistory::memory_usage()
{
  double bytes = grains.capacity() * sizeof(Grain) + (actions.capacity() + restored.capacity()) * sizeof(disc::Action) +
                 neighbours.capacity() * (sizeof(Neighbours) + sizeof(PairMemory) + 2 * sizeof(int) + 1) +
                 first.capacity() * sizeof(int) + close.i.capacity() * (3 * sizeof(int) + 8 * sizeof(double)) +
                 partners.capacity() * sizeof(partners[0]);
  for (const auto &list : partners)
    bytes += list.capacity() * sizeof(Partner);
  return bytes;
}
