/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_feed.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_disc_history.h"
#include "force.h"
#include "keywords.h"
#include "library.h"
#include "modify.h"
#include "pair.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

using namespace LAMMPS_NS;

namespace
{
constexpr double EDGE = 1.0;    // grains this near to a side or to the lower face have left
}

FixDiscFeed::FixDiscFeed(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  vector_flag = 1;
  size_vector = 6;
  extvector = 0;
  global_freq = 1;
  restart_global = 1;
  force_reneighbor = 1;
  next_reneighbor = -1;
  if (narg < 5) error->all(FLERR, "fix disc/feed needs the interval N between looks, in steps, and a file of grains");
  nevery = utils::inumeric(FLERR, arg[3], false, lmp);
  if (nevery < 1) error->all(FLERR, "fix disc/feed: interval N = {} must be at least 1", nevery);
  Keywords(lmp, "fix disc/feed",
           {integer("type", type), number("mass", mass), number("gravity", gravity), number("height", height),
            number("ahead", ahead)})
      .parse(5, narg, arg);
  if (type < 1 || type > atom->ntypes)
    error->all(FLERR, "fix disc/feed: type {} must be from 1 to {}", type, atom->ntypes);
  if (mass <= 0.0 || gravity <= 0.0 || ahead <= 0.0)
    error->all(FLERR, "fix disc/feed: mass, gravity and ahead must be positive");
  read(arg[4]);
}

void FixDiscFeed::read(const char *file)
{
  std::ifstream in(file);
  if (!in) error->all(FLERR, "fix disc/feed: cannot read the grains in '{}'", file);
  for (Grain g; in >> g.tag >> g.time >> g.x >> g.diameter;) {
    if (!grains.empty() && g.time < grains.back().time)
      error->all(FLERR, "fix disc/feed: '{}': times must increase, grain {} comes after a later one", file, g.tag);
    grains.push_back(g);
  }
  if (!in.eof())
    error->all(FLERR, "fix disc/feed: '{}' line {}: expected tag, time, x, diameter", file, grains.size() + 1);
}

int FixDiscFeed::setmask() { return FixConst::POST_INTEGRATE | FixConst::PRE_EXCHANGE; }

void FixDiscFeed::init()
{
  double largest = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    largest = std::max(largest, 2.0 * atom->radius[i]);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  for (const Grain &g : grains)
    if (g.diameter > largest)
      error->all(FLERR,
                 "fix disc/feed: grain {} has diameter {}, above the largest present, {}: cutoff of the law and "
                 "neighbour list are made for that",
                 g.tag, g.diameter, largest);
}

double FixDiscFeed::now() const
{
  return update->atime + update->dt * static_cast<double>(update->ntimestep - update->atimestep);
}

double FixDiscFeed::fall_time(const Grain &g) const { return now() - g.time; }

/* Could an atom of the group or a fixed one be reached before the next look? */
bool FixDiscFeed::is_near(const Grain &g) const
{
  const double t = fall_time(g), y = height - 0.5 * gravity * t * t;
  const double cutoff = force->pair->cutforce + ahead;
  int found = 0;
  for (int i = 0; i < atom->nlocal && !found; i++) {
    const double dx = atom->x[i][0] - g.x, dy = atom->x[i][1] - y;
    found = dy > -cutoff && std::fabs(dx) < cutoff && dx * dx + dy * dy < cutoff * cutoff;
  }
  if (y < domain->boxlo[1] + EDGE + ahead) found = 1;
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_MAX, world);
  return found;
}

bool FixDiscFeed::has_left(int i) const
{
  const double *x = atom->x[i];
  return (atom->mask[i] & groupbit) &&
         (x[0] < domain->boxlo[0] + EDGE || x[0] > domain->boxhi[0] - EDGE || x[1] < domain->boxlo[1] + EDGE);
}

void FixDiscFeed::post_integrate()
{
  if (update->ntimestep % nevery) return;
  const auto inserted = static_cast<size_t>(counts.inserted);
  ready = 0;
  while (inserted + ready < grains.size() && fall_time(grains[inserted + ready]) >= 0.0 &&
         is_near(grains[inserted + ready]))
    ready++;
  int left = 0;
  for (int i = 0; i < atom->nlocal && !left; i++)
    left = has_left(i);
  MPI_Allreduce(MPI_IN_PLACE, &left, 1, MPI_INT, MPI_MAX, world);
  if (ready || left) next_reneighbor = update->ntimestep;
}

void FixDiscFeed::pre_exchange()
{
  if (next_reneighbor != update->ntimestep) return;
  // local indices change: the contact history goes to the grains first
  if (auto *history = dynamic_cast<FixDiscHistory *>(modify->get_fix_by_id(FixDiscHistory::ID)))
    history->pre_exchange();
  // new atoms take the places of ghosts, which come anew with the exchange that follows
  atom->map_clear();
  atom->nghost = 0;
  const auto inserted = static_cast<size_t>(counts.inserted);
  for (size_t k = 0; k < ready; k++)
    insert(grains[inserted + k]);
  ready = 0;
  remove_grains();    // last: an insertion counts the atoms of all ranks anew, those that leave included
}

/* An atom outside a box that is not periodic belongs to nobody after the exchange of atoms that follows. */
void FixDiscFeed::remove_grains()
{
  Counts out;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!has_left(i)) continue;
    const double *v = atom->v[i], m = atom->rmass[i], rim = atom->radius[i] * atom->omega[i][2];
    out.removed += 1.0;
    out.energy_out += m * (0.5 * (v[0] * v[0] + v[1] * v[1] + 0.5 * rim * rim) + gravity * atom->x[i][1]);
    atom->x[i][1] = domain->boxlo[1] - 1.0;
  }
  double sums[2] = {out.removed, out.energy_out};
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, world);
  counts.removed += sums[0];
  counts.energy_out += sums[1];
  atom->natoms -= static_cast<bigint>(sums[0]);
}

/* The step's first half kick is over where this is called: the velocity is that of the half step. */
void FixDiscFeed::insert(const Grain &g)
{
  const double t = fall_time(g), m = mass * g.diameter * g.diameter;
  const double place[3] = {g.x, height - 0.5 * gravity * t * t, 0.0};
  const double velocity[3] = {0.0, -gravity * (t - 0.5 * update->dt), 0.0};
  counts.inserted += 1.0;
  counts.energy_in += m * gravity * height;
  const int before = atom->nlocal;
  lammps_create_atoms(lmp, 1, &g.tag, &type, place, velocity, nullptr, 0);    // on the rank that owns the place
  for (int i = before; i < atom->nlocal; i++) {
    atom->mask[i] = 1 | groupbit;
    atom->radius[i] = 0.5 * g.diameter;
    atom->rmass[i] = m;
    modify->create_attribute(i);
  }
}

double FixDiscFeed::compute_vector(int n)
{
  switch (n) {
  case 0:
    return static_cast<double>(grains.size()) - counts.inserted;
  case 1:
    return counts.inserted;
  case 2:
    return counts.removed;
  case 3:
    return counts.energy_in;
  case 4:
    return counts.energy_out;
  default:
    break;
  }
  double top = domain->boxlo[1];
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) top = std::max(top, atom->x[i][1]);
  MPI_Allreduce(MPI_IN_PLACE, &top, 1, MPI_DOUBLE, MPI_MAX, world);
  return top;
}

void FixDiscFeed::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const int size = sizeof(counts);
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(&counts, size, 1, fp);
}

void FixDiscFeed::restart(char *buf) { memcpy(&counts, buf, sizeof(counts)); }
