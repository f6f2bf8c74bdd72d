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
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using disc::Neighbours;
using disc::Springs;

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

/* ---- when to rebuild ---- */

/* A pair that is not listed was at least R_i + R_j + skin apart when the list was built.  With u the largest
   displacement beyond the affine motion and s < 1 the smallest stretch of the cell since then, it now is at least s
   (R_i + R_j + skin) - 2 u apart, which must stay above R_i + R_j + range. */
void FixDiscHistory::post_integrate()
{
  const double dt = update->dt;
  double stretch[2];
  for (int a = 0; a < 2; a++) {
    const double now = domain->prd[a];
    rate[a] = (now - last_cell[a]) / (0.5 * (now + last_cell[a]) * dt);
    last_cell[a] = now;
    stretch[a] = now / held_cell[a];
  }

  const double *x = atom->x[0];
  const double *h = held.data();
  const double lo[2] = {domain->boxlo[0], domain->boxlo[1]};
  const int nlocal = atom->nlocal;
  double largest = 0.0, sum = 0.0;
  for (int i = 0; i < nlocal; i++) {
    const double ux = x[3 * i] - lo[0] - stretch[0] * h[2 * i];
    const double uy = x[3 * i + 1] - lo[1] - stretch[1] * h[2 * i + 1];
    const double u2 = ux * ux + uy * uy;
    largest = std::max(largest, u2);
    sum += u2;    // remembers a NaN, which a maximum forgets
  }
  if (!std::isfinite(sum))
    error->one(
        FLERR,
        "the position of a grain is not a number at step {}: centres of two grains coincide, or the step {} is far too "
        "large",
        update->ntimestep, dt);
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);

  const double smallest = std::min({1.0, stretch[0], stretch[1]});
  const double slack = smallest * neighbor->skin - range - 2.0 * (1.0 - smallest) * largest_radius;
  if (2.0 * std::sqrt(largest) >= slack) next_reneighbor = update->ntimestep;
}

void FixDiscHistory::hold()
{
  const int nlocal = atom->nlocal;
  held.resize(2 * static_cast<size_t>(nlocal));
  for (int i = 0; i < nlocal; i++) {
    held[2 * i] = atom->x[i][0] - domain->boxlo[0];
    held[2 * i + 1] = atom->x[i][1] - domain->boxlo[1];
  }
  for (int a = 0; a < 2; a++)
    held_cell[a] = domain->prd[a];
}

/* ---- from the records to the grains ---- */

void FixDiscHistory::setup_pre_exchange()
{
  for (int a = 0; a < 2; a++)
    last_cell[a] = domain->prd[a];
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
  for (const Neighbours &p : pairs) {
    if (p.springs.stretch == 0.0 && p.springs.rotation == 0.0) continue;
    partners[p.i].push_back({tag[p.j], p.springs});
    // with newton off the owner of a ghost has a record of its own
    if (newton || p.j < nlocal) partners[p.j].push_back({tag[p.i], {p.springs.stretch, -p.springs.rotation}});
  }
  if (newton) comm->reverse_comm_variable(this);
  maxexchange = 1;
  for (int i = 0; i < nlocal; i++)
    maxexchange = std::max(maxexchange, 1 + ENTRY * static_cast<int>(partners[i].size()));
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

  pairs.clear();
  first.assign(nlocal + 1, 0);
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    first[i] = static_cast<int>(pairs.size());
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      Springs springs{0.0, 0.0};
      for (const Partner &partner : partners[i])
        if (partner.tag == tag[j]) springs = partner.springs;
      pairs.push_back({i, j, radius[i], radius[j], law->viscosity(i, j), springs, 0.0});
    }
  }
  first[nlocal] = static_cast<int>(pairs.size());
  hold();
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

const Neighbours *FixDiscHistory::find(int i, int j) const
{
  for (int k = first[i]; k < first[i + 1]; k++)
    if (pairs[k].j == j) return &pairs[k];
  return nullptr;
}

/* ---- per-atom bookkeeping of LAMMPS ---- */

void FixDiscHistory::grow_arrays(int nmax)
{
  if (static_cast<int>(partners.size()) < nmax) partners.resize(nmax);
}

void FixDiscHistory::copy_arrays(int i, int j, int /*delflag*/) { partners[j] = partners[i]; }

void FixDiscHistory::set_arrays(int i) { partners[i].clear(); }

int FixDiscHistory::pack_exchange(int i, double *buf)
{
  int m = 0;
  buf[m++] = static_cast<double>(partners[i].size());
  for (const Partner &p : partners[i]) {
    buf[m++] = ubuf(p.tag).d;
    buf[m++] = p.springs.stretch;
    buf[m++] = p.springs.rotation;
  }
  return m;
}

int FixDiscHistory::unpack_exchange(int nlocal, double *buf)
{
  int m = 0;
  partners[nlocal].resize(static_cast<size_t>(buf[m++]));
  for (Partner &p : partners[nlocal]) {
    p.tag = static_cast<tagint>(ubuf(buf[m++]).i);
    p.springs.stretch = buf[m++];
    p.springs.rotation = buf[m++];
  }
  return m;
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
    m += pack_exchange(i, buf + m);
  return m;
}

void FixDiscHistory::unpack_reverse_comm(int n, int *list, double *buf)
{
  int m = 0;
  for (int k = 0; k < n; k++) {
    auto &mine = partners[list[k]];
    for (int count = static_cast<int>(buf[m++]); count > 0; count--) {
      mine.push_back({static_cast<tagint>(ubuf(buf[m]).i), {buf[m + 1], buf[m + 2]}});
      m += ENTRY;
    }
  }
}

/* ---- restart ---- */

void FixDiscHistory::write_restart(FILE *fp)
{
  // memory may be newer in the records than in the partner lists: the restart step's own force evaluation came since
  if (listed) remember();
  double sums[3] = {loss.viscous, loss.sliding, loss.rolling};
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, world);
  const double state[5] = {sums[0], sums[1], sums[2], rate[0], rate[1]};
  if (comm->me == 0) {
    const int size = sizeof(state);
    fwrite(&size, sizeof(int), 1, fp);
    fwrite(state, size, 1, fp);
  }
}

void FixDiscHistory::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  if (comm->me == 0) loss = {state[0], state[1], state[2]};
  rate[0] = state[3];
  rate[1] = state[4];
}

int FixDiscHistory::pack_restart(int i, double *buf)
{
  const int m = pack_exchange(i, buf + 1);
  buf[0] = m + 1;
  return m + 1;
}

void FixDiscHistory::unpack_restart(int nlocal, int nth)
{
  double *extra = atom->extra[nlocal];
  int m = 0;
  for (int k = 0; k < nth; k++)
    m += static_cast<int>(extra[m]);
  unpack_exchange(nlocal, extra + m + 1);
}

int FixDiscHistory::size_restart(int i) { return 2 + ENTRY * static_cast<int>(partners[i].size()); }

int FixDiscHistory::maxsize_restart()
{
  int most = 0;
  for (const auto &list : partners)
    most = std::max(most, static_cast<int>(list.size()));
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, world);
  return 2 + ENTRY * most;
}

double FixDiscHistory::memory_usage()
{
  double bytes = pairs.capacity() * sizeof(Neighbours) + partners.capacity() * sizeof(partners[0]);
  for (const auto &list : partners)
    bytes += list.capacity() * sizeof(Partner);
  return bytes + held.capacity() * sizeof(double) + first.capacity() * sizeof(int);
}
