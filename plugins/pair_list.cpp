/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "pair_list.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "pair_disc.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using disc::ContactHistory;
using disc::Grain;

/* ---- how far grains moved ---- */

/* Two centres at a distance b come to s b - 2 u at least, with u the largest displacement beyond the affine motion and
   s < 1 the smaller scaling of the cell; unlisted pairs are less than 2 R + skin apart where it matters. */
void PairList::record_displacement(double largest, const double *cell_scaling)
{
  state.set_kinematics(cell_scaling, second_order);
  if (comm->nprocs > 1) MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  const double smallest = std::min({1.0, cell_scaling[0], cell_scaling[1]});
  last_displacement = 2.0 * largest + (1.0 - smallest) * (2.0 * largest_radius + neighbor->skin);
  skin_left -= last_displacement;
  active_skin_left -= last_displacement;
  mark_cell();
  recorded = true;
}

void PairList::mark_cell()
{
  for (int a = 0; a < 2; a++) {
    last_cell[a] = domain->prd[a];
    last_corner[a] = domain->boxlo[a];
  }
}

/* For integrators that do not call record_displacement(): `grains` still holds the positions of the last evaluation. */
void PairList::track_displacement()
{
  if (recorded) {
    recorded = false;
    return;
  }
  const double scaling[2] = {domain->prd[0] / last_cell[0], domain->prd[1] / last_cell[1]};
  double largest = 0.0, sum = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    const double ux = atom->x[i][0] - domain->boxlo[0] - scaling[0] * (state.grains[i].x - last_corner[0]);
    const double uy = atom->x[i][1] - domain->boxlo[1] - scaling[1] * (state.grains[i].y - last_corner[1]);
    largest = std::max(largest, ux * ux + uy * uy);
    sum += ux * ux + uy * uy;    // keeps a NaN, which a maximum loses
  }
  require_number(sum);
  record_displacement(std::sqrt(largest), scaling);
  recorded = false;
}

void PairList::require_number(double sum) const
{
  if (!std::isfinite(sum))
    error->one(
        FLERR,
        "the position of a grain is not a number at step {}: centres of two grains coincide, or the step {} is far too "
        "large",
        update->ntimestep, update->dt);
}

/* ---- neighbours ---- */

void PairList::build(const PairDisc &law, const Saved &saved)
{
  const NeighList *list = law.list;
  largest_radius = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    largest_radius = std::max(largest_radius, atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest_radius, 1, MPI_DOUBLE, MPI_MAX, world);
  require_unique_images(2.0 * largest_radius + neighbor->skin);

  neighbors.clear();
  history.clear();
  has_history.clear();
  first.assign(atom->nlocal, 0);
  for (int ii = 0; ii < list->inum; ii++) {
    const int i = list->ilist[ii];
    first[i] = static_cast<int>(neighbors.size());
    for (int jj = 0; jj < list->numneigh[i]; jj++) {
      const int j = list->firstneigh[i][jj] & NEIGHMASK;
      const ContactHistory *const found = saved(i, atom->tag[j]);
      neighbors.push_back({i, j, law.pair_constant(i, j)});
      history.push_back(found ? *found : ContactHistory{});
      has_history.push_back(found != nullptr);
    }
  }
  skin_left = neighbor->skin - cutoff_gap;
  active_skin_left = 0.0;    // `active` is made before the next evaluation
  newly_built = true;
}

/* Contacts are keyed by the partner's tag: a grain must meet at most one image of another one. */
void PairList::require_unique_images(double reach) const
{
  for (int a = 0; a < 2; a++)
    if (domain->periodicity[a] && domain->prd[a] < 2.0 * reach)
      error->all(
          FLERR,
          "cell length {} along {} is below {} = 2 (largest diameter + skin): two images of one grain could touch "
          "the same grain; use a larger cell or more grains",
          domain->prd[a], a ? 'y' : 'x', 2.0 * reach);
}

int PairList::find(int i, int j) const
{
  for (int k = first[i]; k < static_cast<int>(neighbors.size()) && neighbors[k].i == i; k++)
    if (neighbors[k].j == j) return active_index[k];
  return -1;
}

/* ---- active pairs ---- */

void PairList::read_histories()
{
  history.assign(neighbors.size(), ContactHistory{});
  has_history.assign(neighbors.size(), 0);
  for (int c = 0; c < active.count; c++) {
    history[active.neighbor[c]] = active.history_of(c);
    has_history[active.neighbor[c]] = 1;
  }
}

/* The wider the skin of the active pairs, the more of them do not interact; the narrower, the more often they are
   selected: the sum costs least with a skin that grows like the root of the displacement per step (measured: 0.2 R
   times it, dense and gas alike). */
void PairList::select_pairs()
{
  active_skin_left =
      std::min(skin_left, std::max(1.0e-4 * largest_radius, std::sqrt(0.2 * largest_radius * last_displacement)));
  const double reach = cutoff_gap + active_skin_left;
  selected.clear();
  for (int k = 0; k < static_cast<int>(neighbors.size()); k++) {
    const Grain &a = state.grains[neighbors[k].i], &b = state.grains[neighbors[k].j];
    const double bx = b.x - a.x, by = b.y - a.y, cutoff = a.r + b.r + reach;
    if (bx * bx + by * by < cutoff * cutoff) selected.push_back(k);
  }
}

/* Pairs of one grain are neighbours in the list.  Within a block they are dealt out, so that the kernel does not read a
   record back that it has just written: the processor would wait for it. */
void PairList::rebuild_pair_list(PairDisc &law)
{
  if (!pair_list_due()) return;
  if (!newly_built) read_histories();
  newly_built = false;
  select_pairs();
  active_index.assign(neighbors.size(), -1);
  active.clear(columns.count);
  const int count = static_cast<int>(selected.size());
  for (int start = 0; start < count; start += disc::BLOCK) {
    const int end = std::min(start + disc::BLOCK, count), stride = (end - start + disc::LANES - 1) / disc::LANES;
    for (int offset = start; offset < start + stride; offset++)
      for (int c = offset; c < end; c += stride) {
        const int k = selected[c];
        const Neighbor &p = neighbors[k];
        active_index[k] = active.count;
        active.add(p.i, p.j, k, p.pair_constant, has_history[k] ? history[k] : new_pair_history(p));
      }
  }
  active.pad();
  law.ghosts.select_ghosts(active);
}

/* The velocities in the middle of the step, as the kernels compute them (the sliding velocity for discs in contact). */
ContactHistory PairList::new_pair_history(const Neighbor &p) const
{
  ContactHistory h{};
  if (!second_order) return h;
  const disc::StepKinematics &step = state.kinematics;
  const Grain &a = state.grains[p.i], &b = state.grains[p.j];
  const double bx = b.x - a.x, by = b.y - a.y, distance = std::sqrt(bx * bx + by * by);
  const double ux = step.velocity_factor[0] * (b.vx - a.vx) + step.affine_rate[0] * bx;
  const double uy = step.velocity_factor[1] * (b.vy - a.vy) + step.affine_rate[1] * by;
  const double un = (bx * ux + by * uy) / distance, ut = (bx * uy - by * ux) / distance;
  const double n_rotation = 0.5 * step.dt * ut / distance;
  for (int m = 0; m < columns.count; m++) {
    if (columns[m].kind == disc::HistoryColumn::VN) h[m] = un - n_rotation * ut;
    if (columns[m].kind == disc::HistoryColumn::VT) h[m] = ut + n_rotation * un - (a.rw + b.rw);
  }
  return h;
}

void PairList::scale_springs(double factor)
{
  for (int m = 0; m < columns.count; m++)
    if (columns[m].kind == disc::HistoryColumn::SPRING)
      for (int c = 0; c < active.count; c++)
        active.history[m][c] *= factor;
}

/* Computed from the law as it is now, as when lists are made: a run that resumes here has the same bits. */
void PairList::update_pair_constants(const PairDisc &law)
{
  for (Neighbor &p : neighbors)
    p.pair_constant = law.pair_constant(p.i, p.j);
  for (int c = 0; c < active.count; c++)
    active.pair_constant[c] = neighbors[active.neighbor[c]].pair_constant;
}

double PairList::memory_usage() const
{
  const size_t per_neighbor = sizeof(Neighbor) + sizeof(ContactHistory) + 2 * sizeof(int) + 1;
  const size_t per_pair = 3 * sizeof(int) + (1 + columns.count) * sizeof(double);
  return static_cast<double>(neighbors.capacity() * per_neighbor + first.capacity() * sizeof(int) +
                             active.i.capacity() * per_pair);
}
