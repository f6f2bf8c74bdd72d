/* SPDX-License-Identifier: GPL-2.0-or-later */

#include "fix_disc_stiffen.h"

#include "comm.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "pair_disc.h"
#include "rank_sums.h"
#include "update.h"
#include "utils.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

FixDiscStiffen::FixDiscStiffen(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  scalar_flag = vector_flag = 1;
  size_vector = 2;
  extscalar = extvector = 0;
  global_freq = 1;
  restart_global = 1;
  if (narg != 6) error->all(FLERR, "fix disc/stiffen needs three values: interval N in steps, factor, time");
  nevery = utils::inumeric(FLERR, arg[3], false, lmp);
  factor = utils::numeric(FLERR, arg[4], false, lmp);
  duration = utils::numeric(FLERR, arg[5], false, lmp);
  if (nevery < 1) error->all(FLERR, "fix disc/stiffen: interval N = {} must be at least 1", nevery);
  if (factor <= 0.0) error->all(FLERR, "fix disc/stiffen: factor = {} must be positive", factor);
  if (duration < 0.0) error->all(FLERR, "fix disc/stiffen: time = {} must not be negative", duration);
}

int FixDiscStiffen::setmask() { return FixConst::PRE_FORCE; }

/* The law of the deck is that before the ramp, also after a restart: what the ramp had reached then comes back here. */
void FixDiscStiffen::init()
{
  pair = dynamic_cast<PairDisc *>(force->pair);
  history = dynamic_cast<FixDiscHistory *>(modify->get_fix_by_id(FixDiscHistory::ID));
  if (!pair || !history)
    error->all(FLERR, "fix disc/stiffen works with the pair styles of its plugin, such as disc/cohesive");
  const bool first = !stiffness[0];
  const char *names[STIFFNESSES] = {"kn", "kt", "kr"};
  for (int k = 0; k < STIFFNESSES; k++) {
    int dimension;
    stiffness[k] = static_cast<double *>(pair->extract(names[k], dimension));
    if (!stiffness[k]) error->all(FLERR, "fix disc/stiffen: pair_style {} has no {}", force->pair_style, names[k]);
    if (first) initial[k] = *stiffness[k];
  }
  if (begun < 0) begun = update->ntimestep;
  set(now);
}

double FixDiscStiffen::reached(bigint step) const
{
  const double passed = static_cast<double>(step - begun) * update->dt;
  return passed < duration ? std::pow(factor, passed / duration) : factor;
}

void FixDiscStiffen::set(double value)
{
  now = value;
  for (int k = 0; k < STIFFNESSES; k++)
    *stiffness[k] = initial[k] * now;
}

double FixDiscStiffen::stored() const
{
  double sum = 0.0;
  pair->each(
      [&](int, int, const PairDisc::Interaction &one, double weight) { sum += weight * pair->energy(one).sum(); });
  return sum;
}

/* Positions, ghosts and list are those of the force evaluation that follows. */
void FixDiscStiffen::pre_force(int)
{
  if (update->setupflag || now == factor || (update->ntimestep - begun) % nevery != 0) return;
  pair->choose_close();
  const double before = stored(), ratio = reached(update->ntimestep) / now;
  history->rescale(1.0 / ratio);
  set(reached(update->ntimestep));
  history->renew_viscosity();
  work += stored() - before;
}

double FixDiscStiffen::compute_scalar() { return now == factor ? 1.0 : 0.0; }

double FixDiscStiffen::compute_vector(int n)
{
  if (n == 0) return now;
  double total = work;
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_SUM, world);
  return total;
}

void FixDiscStiffen::write_restart(FILE *fp)
{
  std::vector<double> state = {now, ubuf(begun).d};
  save_rank_sums(world, {work}, state);
  if (comm->me != 0) return;
  const int size = static_cast<int>(state.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(state.data(), size, 1, fp);
}

void FixDiscStiffen::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  now = state[0];
  double first = state[1];
  begun = static_cast<bigint>(ubuf(first).i);
  work = restore_rank_sums(world, state + 2, 1)[0];
}
