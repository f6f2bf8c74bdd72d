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

/* The law of the deck is that before the ramp, also after a restart: the factor reached then is applied here. */
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
  if (ramp_start < 0) ramp_start = update->ntimestep;
  set_factor(reached);
}

double FixDiscStiffen::factor_at(bigint step) const
{
  const double elapsed = static_cast<double>(step - ramp_start) * update->dt;
  return elapsed < duration ? std::pow(factor, elapsed / duration) : factor;
}

void FixDiscStiffen::set_factor(double value)
{
  reached = value;
  for (int k = 0; k < STIFFNESSES; k++)
    *stiffness[k] = initial[k] * reached;
}

double FixDiscStiffen::stored_energy() const
{
  double sum = 0.0;
  pair->for_each_pair(
      [&](int, int, const PairDisc::Interaction &one, double weight) { sum += weight * pair->energy(one).sum(); });
  return sum;
}

/* Positions, ghosts and list are those of the force evaluation that follows. */
void FixDiscStiffen::pre_force(int)
{
  if (update->setupflag || reached == factor || (update->ntimestep - ramp_start) % nevery != 0) return;
  pair->rebuild_pair_list();
  const double before = stored_energy(), ratio = factor_at(update->ntimestep) / reached;
  history->pairs.scale_springs(1.0 / ratio);
  set_factor(factor_at(update->ntimestep));
  history->pairs.update_pair_constants(*pair);
  work += stored_energy() - before;
}

double FixDiscStiffen::compute_scalar() { return reached == factor ? 1.0 : 0.0; }

double FixDiscStiffen::compute_vector(int n)
{
  if (n == 0) return reached;
  double total = work;
  MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_SUM, world);
  return total;
}

void FixDiscStiffen::write_restart(FILE *fp)
{
  std::vector<double> state = {reached, ubuf(ramp_start).d};
  save_rank_sums(world, {work}, state);
  if (comm->me != 0) return;
  const int size = static_cast<int>(state.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(state.data(), size, 1, fp);
}

void FixDiscStiffen::restart(char *buf)
{
  const auto *state = reinterpret_cast<const double *>(buf);
  reached = state[0];
  double first = state[1];
  ramp_start = static_cast<bigint>(ubuf(first).i);
  work = restore_rank_sums(world, state + 2, 1)[0];
}
